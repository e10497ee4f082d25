// Each page becomes one file: scripts, styles and the engine are inside, so it opens from a disk, without a network.
import { readFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';
import { defineConfig } from 'vite';

const ENGINE = 'virtual:engine';

/** `import packed from 'virtual:engine'`: the wasm file, gzipped, in base64. */
const engine = {
  name: 'engine',
  resolveId: (id) => (id === ENGINE ? `\0${ENGINE}` : null),
  load(id) {
    if (id !== `\0${ENGINE}`) return null;
    const wasm = readFileSync(new URL('generated/ishigaki_bg.wasm', import.meta.url));
    return `export default ${JSON.stringify(gzipSync(wasm, { level: 9 }).toString('base64'))};`;
  },
};

/** Puts scripts and styles into the page. */
const inline = {
  name: 'inline',
  enforce: 'post',
  generateBundle(_, bundle) {
    const take = (file) => {
      const name = file.replace(/^\.\//, '');
      const found = bundle[name];
      if (!found) throw new Error(`the page names ${name}, which was not built`);
      delete bundle[name];
      return String(found.code ?? found.source);
    };
    for (const page of Object.values(bundle).filter((file) => file.fileName.endsWith('.html'))) {
      page.source = String(page.source)
        .replace(/<link rel="stylesheet"[^>]*href="([^"]+)"[^>]*>/g, (_, file) => `<style>${take(file)}</style>`)
        .replace(/<script type="module"[^>]*src="([^"]+)"[^>]*><\/script>/g, (_, file) => {
          const code = take(file).replace(/<\/script/g, '<\\/script');
          return `<script type="module">${code}</script>`;
        });
    }
  },
};

export default defineConfig(({ mode }) => ({
  base: './',
  plugins: [engine, inline],
  build: {
    target: 'es2022',
    outDir: 'dist',
    emptyOutDir: false,
    modulePreload: false,
    reportCompressedSize: false,
    chunkSizeWarningLimit: 4000,
    rollupOptions: { input: mode === 'replay' ? 'replay.html' : 'index.html', output: { codeSplitting: false } },
  },
}));

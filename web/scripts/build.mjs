// `npm run build`: type check, then both pages into dist/. The engine must be in generated/: `cargo xtask web` does all.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { gzipSync } from 'node:zlib';
import { build } from 'vite';

process.chdir(new URL('..', import.meta.url).pathname);
const WASM = 'generated/ishigaki_bg.wasm';
/** Of the engine, gzipped. */
const BUDGET = 1_000_000;

if (!existsSync(WASM)) {
  console.error(`${WASM} is not there: run \`cargo xtask web\`, which builds the engine first`);
  process.exit(1);
}
execFileSync(process.execPath, ['node_modules/typescript/bin/tsc', '--noEmit'], { stdio: 'inherit' });
rmSync('dist', { recursive: true, force: true });
mkdirSync('dist');
for (const mode of ['index', 'replay']) await build({ mode, logLevel: 'warn' });

const wasm = readFileSync(WASM);
const sizes = {
  wasm: wasm.length,
  wasm_gzip: gzipSync(wasm, { level: 9 }).length,
  index_html: statSync('dist/index.html').size,
  replay_html: statSync('dist/replay.html').size,
};
writeFileSync('dist/sizes.json', `${JSON.stringify(sizes, null, 2)}\n`);
console.error(`web/dist: ${Object.entries(sizes).map(([name, bytes]) => `${name} ${(bytes / 1000).toFixed(0)} kB`).join(', ')}`);
if (sizes.wasm_gzip > BUDGET) {
  console.error(`the engine is larger than its budget of ${BUDGET / 1000} kB compressed`);
  process.exit(1);
}

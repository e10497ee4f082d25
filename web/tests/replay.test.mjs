// The replay page in a real browser, with recordings of the native program.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { launch, openPage, serve } from './browser.mjs';
import { picture } from './picture.mjs';

const program = process.env.ISHIGAKI_BIN;
const folder = mkdtempSync(join(tmpdir(), 'ishigaki-web-'));
const STEPS = 150;
let browser, server, recording, states;

before(async () => {
  assert.ok(program, 'ISHIGAKI_BIN names the native program; `cargo xtask test` sets it');
  const [ishi, csv] = [join(folder, 'pile.ishi'), join(folder, 'pile.csv')];
  const flags = ['--steps', STEPS, '--record', ishi, '--record-contacts', '--states', csv, '--quiet'].map(String);
  execFileSync(program, ['run', 'pile', '--param', 'n=12', ...flags]);
  recording = readFileSync(ishi);
  states = readFileSync(csv, 'utf8').trim().split('\n').slice(1).map((line) => line.split(','));
  const page = readFileSync(new URL('../dist/replay.html', import.meta.url), 'utf8');
  const parts = page.split('@ISHIGAKI_RECORDING@');
  assert.equal(parts.length, 2, 'the mark is there exactly once');
  browser = await launch();
  server = await serve({
    '/view/': Buffer.from(page),
    '/view/recording.ishi': recording,
    '/empty/replay.html': Buffer.from(page),
    '/inside.html': Buffer.from(parts.join(gzipSync(recording).toString('base64'))),
    '/plain.html': Buffer.from(parts.join(recording.toString('base64'))),
  });
});
after(async () => {
  await browser?.close();
  server?.close();
  rmSync(folder, { recursive: true });
});

async function replay(path, size = { width: 700, height: 500 }) {
  const { page, problems } = await openPage(browser, `${server.address}${path}`, size);
  await page.waitForFunction('window.ishigaki');
  return { page, problems };
}

/** Position and rotation of all bodies as the program wrote them, in 32 bits. */
function expected(step) {
  const lines = states.filter((line) => Number(line[0]) === step);
  return lines.flatMap((line) => line.slice(4, 11).map((x) => Math.fround(Number(x))));
}

const shown = (page) => page.evaluate(() => Array.from(ishigaki.recording.frame(ishigaki.frame).poses));

for (const path of ['/view/?quality=low', '/inside.html?quality=low', '/plain.html?quality=low']) {
  test(`${path}: any frame shows the poses of the run`, async () => {
    // Without a frame in its address a page plays, and moves on between asking for a frame and reading it.
    const { page, problems } = await replay(`${path}#frame=0`);
    await page.waitForFunction(() => ishigaki.recording);
    assert.equal(await page.evaluate(() => ishigaki.playing), false);
    assert.equal(await page.evaluate(() => ishigaki.recording.length), STEPS + 1);
    // Forwards, backwards over key frames, the ends.
    for (const frame of [70, 71, 3, 150, 0, 129]) {
      await page.evaluate((f) => {
        const slider = document.querySelector('input[type=range]');
        slider.value = f;
        slider.dispatchEvent(new Event('input'));
      }, frame);
      assert.deepEqual(await shown(page), expected(frame), `frame ${frame}`);
      assert.ok((await page.locator('.counter').innerText()).startsWith(`${frame} /`));
      await page.keyboard.press('ArrowRight');
      assert.equal(await page.evaluate(() => ishigaki.frame), Math.min(frame + 1, STEPS));
    }
    assert.deepEqual(problems, []);
    await page.close();
  });
}

test('it plays, pauses, steps, starts at the frame of the address, and shows contacts', async () => {
  const { page, problems } = await replay('/view/?quality=low#frame=100');
  await page.waitForFunction(() => ishigaki.recording);
  const frame = () => page.evaluate(() => ishigaki.frame);
  assert.equal(await frame(), 100);
  await page.keyboard.press('ArrowLeft');
  assert.equal(await frame(), 99);
  await page.keyboard.press('Home');
  // Slowly: at the end of the recording `Space` would start it over instead of pausing it.
  await page.getByLabel('Speed').evaluate((field) => {
    field.value = '0.1';
    field.dispatchEvent(new Event('change'));
  });
  await page.keyboard.press('Space');
  await page.waitForFunction(() => ishigaki.frame > 5);
  await page.keyboard.press('Space');
  const paused = await frame();
  await page.waitForTimeout(150);
  assert.equal(await frame(), paused);
  await page.keyboard.press('End');
  assert.equal(await frame(), STEPS);
  const before = await picture(page, '#stage');
  await page.keyboard.press('1');
  await page.waitForTimeout(300);
  const [count, arrows] = await page.evaluate(() => [ishigaki.recording.measures(ishigaki.frame).contacts, ishigaki.recording.arrows(ishigaki.frame).length]);
  assert.ok(count > 5);
  assert.equal(arrows, 8 * count);
  const [plain, marked] = [before, await picture(page, '#stage')].map((p) => p.region(0.2, 0.2, 0.8, 0.9));
  assert.ok(Math.abs(plain.light - marked.light) + Math.abs(plain.spread - marked.spread) > 1e-3, 'arrows are seen');
  assert.ok(plain.spread > 0.03, 'bodies are seen');
  assert.deepEqual(problems, []);
  await page.close();
});

test('bad files say what is wrong, good ones are played', async () => {
  const { page, problems } = await replay('/empty/replay.html?quality=low');
  await page.locator('.welcome').waitFor();
  const drop = (name, bytes) =>
    page.evaluate(
      async ([n, data]) => {
        const transfer = new DataTransfer();
        transfer.items.add(new File([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], n));
        dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, cancelable: true }));
      },
      [name, Buffer.from(bytes).toString('base64')],
    );
  const refused = (text) => page.locator('.toast.error', { hasText: text }).last().waitFor();
  const changed = (at, value) => {
    const copy = Buffer.from(recording);
    copy[at] = value;
    return copy;
  };
  await drop('notes.txt', 'hello');
  await refused('notes.txt: is not a recording');
  await drop('head.ishi', changed(8, 7));
  await refused('the checksum of its head');
  await drop('scene.ishi', changed(40, 0));
  await refused('is damaged before its first frame');
  assert.equal(await page.evaluate(() => ishigaki.recording), null);
  await drop('cut.ishi', recording.subarray(0, Math.floor(recording.length / 2)));
  await refused('is cut off or damaged after frame');
  const half = await page.evaluate(() => ishigaki.recording.length);
  assert.ok(half > 20 && half < STEPS, `${half} frames of the half are played`);
  await drop('pile.ishi', recording);
  await page.waitForFunction((n) => ishigaki.recording.length === n, STEPS + 1);
  // The page asked for a recording beside it, and there was none.
  assert.ok(problems.every((p) => p.includes('404')), problems.join());
  await page.close();
});

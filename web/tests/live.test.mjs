// The live page in a real browser.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { picture } from './picture.mjs';
import { launch, openPage, serve } from './browser.mjs';

let browser, server;
before(async () => {
  [browser, server] = [await launch(), await serve()];
});
after(async () => {
  await browser.close();
  server.close();
});

/** The page at an address; what goes wrong in it fails the test. */
async function live(hash, size, options) {
  const quality = options?.quality ?? 'low';
  const { page, problems } = await openPage(browser, `${server.address}/?quality=${quality}${hash}`, size, options);
  await page.waitForFunction('window.ishigaki', null, { timeout: 30000 });
  return { page, close: async () => (await page.close(), assert.deepEqual(problems, [])) };
}

const options = (page, side = 0) => page.evaluate((i) => Object.fromEntries(ishigaki.session.sides[i].world.options()), side);
const report = (page) => page.evaluate(() => ishigaki.session.first.world.report);
const change = (page, selector, value) =>
  page.locator(selector).evaluate((field, v) => {
    if (field.type === 'checkbox') field.checked = v;
    else field.value = v;
    field.dispatchEvent(new Event('change'));
  }, value);

test('every named scene runs 120 frames', async () => {
  const { page, close } = await live('#scene=tower', { width: 360, height: 260 });
  const scenes = await page.locator('#scene option').evaluateAll((list) => list.map((o) => o.value));
  assert.ok(scenes.length > 15);
  for (const scene of scenes) {
    const result = await page.evaluate(async (name) => {
      const { session } = ishigaki;
      const picker = document.querySelector('#scene');
      picker.value = name;
      picker.dispatchEvent(new Event('change'));
      session.playing = false;
      // A frame of the page's own loop, as often as the screen would ask for one.
      for (let i = 0; i < 120; i++) session.step();
      const drawn = ishigaki.frames;
      while (ishigaki.frames === drawn) await new Promise(requestAnimationFrame);
      const { report, about } = session.first.world;
      return { name: about.name, step: report.step, lost: report.non_finite.length, rejected: report.rejected };
    }, scene);
    assert.deepEqual(result, { name: scene, step: 120, lost: 0, rejected: null });
  }
  await close();
});

test('each control changes the option of the engine that it names, and no option is without one', async () => {
  const { page, close } = await live('#scene=tower&n=3&paused=1', { width: 900, height: 600 });
  const before = await options(page);
  const fields = await page.locator('[data-path]').evaluateAll((list) =>
    list.map((field) => ({
      path: field.dataset.path,
      kind: field.tagName === 'SELECT' ? 'select' : field.type,
      choices: [...(field.options ?? [])].map((o) => o.value),
    })),
  );
  assert.deepEqual(fields.map((f) => f.path).sort(), Object.keys(before).sort());
  for (const { path, kind, choices } of fields) {
    const old = before[path];
    const other = {
      checkbox: () => old !== 'true',
      select: () => choices.find((c) => c !== old),
      number: () => (/rate|factor$/.test(path) && Number(old) <= 1 ? '0.25' : String(Number(old) + 1)),
      text: () => '[0.0,-1.5,0.0]',
    }[kind]();
    // Within what is allowed.
    const narrow = { 'solver.shock_propagation.blend': '0.5', 'solver.over_relaxation.factor': '1.25' };
    const value = narrow[path] ?? other;
    await change(page, `[data-path="${path}"]`, value);
    const now = await options(page);
    const same = kind === 'number' ? Math.abs(Number(now[path]) / Number(value) - 1) < 1e-6 : now[path] === String(value);
    assert.ok(same, `${path}: wanted ${value}, the engine has ${now[path]}`);
    const shown = await page.locator(`[data-path="${path}"]`).evaluate((f) => (f.type === 'checkbox' ? String(f.checked) : f.value));
    assert.equal(shown, now[path], `${path} is shown as it is`);
  }
  // A value that the engine refuses is said, and the field shows what holds.
  await change(page, '[data-path="solver.weight_amplification.factor"]', '0.5');
  await page.locator('.toast.error', { hasText: 'must be finite and ≥ 1' }).waitFor();
  assert.notEqual((await options(page))['solver.weight_amplification.factor'], '0.5');
  await page.locator('[data-preset=plain]').click();
  assert.equal((await options(page))['solver.warm_start.enabled'], 'false');
  await close();
});

test('two configurations run side by side in step, and a link carries both', async () => {
  const hash = '#scene=tower&n=12&a=solver:plain&b=solver:talk&show=contacts&color=height&paused=1';
  const { page, close } = await live(hash, { width: 900, height: 500 });
  const state = () =>
    page.evaluate(() => ishigaki.session.sides.map(({ world }) => ({ step: world.report.step, pen: world.report.max_penetration })));
  await page.evaluate(() => {
    for (let i = 0; i < 90; i++) ishigaki.session.step();
  });
  const [a, b] = await state();
  assert.deepEqual([a.step, b.step], [90, 90]);
  assert.ok(a.pen > 10 * b.pen, `plain sinks (${a.pen} m), the talk's techniques hold (${b.pen} m)`);
  assert.equal((await options(page, 0))['solver.warm_start.enabled'], 'false');
  assert.equal((await options(page, 1))['solver.weight_amplification.enabled'], 'true');
  const labels = await page.locator('.side-label').allInnerTexts();
  assert.deepEqual(labels.map((l) => l.replace(/\s+/g, ' ')), ['A plain', 'B talk']);
  await page.locator('.side-b').last().click();
  await change(page, '[data-path="solver.sweeps"]', '7');
  const link = await page.evaluate(() => location.hash);
  for (const part of ['scene=tower', 'n=12', 'a=solver:plain', 'b=solver:talk', 'b=solver.sweeps:7', 'show=contacts', 'color=height']) {
    assert.ok(link.includes(part), `${link} has ${part}`);
  }
  await page.keyboard.press('c');
  assert.equal(await page.evaluate(() => ishigaki.session.sides.length), 1);
  await close();
});

test('keys play, step, reset and shoot; a snapshot brings the state back', async () => {
  const { page, close } = await live('#scene=tower&n=5&paused=1', { width: 900, height: 600 });
  const hash = () => page.evaluate(() => ishigaki.session.first.world.hash());
  const start = await hash();
  await page.keyboard.press('.');
  await page.keyboard.press('.');
  assert.equal((await report(page)).step, 2);
  await page.keyboard.press('s');
  const saved = await hash();
  await page.keyboard.press('f');
  assert.equal(await page.evaluate(() => ishigaki.session.first.world.model.bodies.at(-1).name), 'shot');
  await page.keyboard.press('Space');
  await page.waitForFunction(() => ishigaki.session.first.world.report.step > 10);
  await page.keyboard.press('Space');
  assert.notEqual(await hash(), saved);
  await page.keyboard.press('l');
  assert.equal(await hash(), saved);
  await page.keyboard.press('r');
  assert.equal(await hash(), start);
  assert.equal((await report(page)).step, 0);
  await close();
});

test('the mouse pulls a body up and lets it go', async () => {
  const { page, close } = await live('#scene=tower&n=1&paused=1', { width: 900, height: 600 });
  const place = await page.evaluate(() => {
    const { session, stage } = ishigaki;
    const [x, y, z] = session.first.frame.poses.slice(7, 10);
    const point = stage.controls.target.clone().set(x, y, z).project(stage.camera);
    const box = document.querySelector('#stage').getBoundingClientRect();
    return { x: box.left + ((point.x + 1) / 2) * box.width, y: box.top + ((1 - point.y) / 2) * box.height };
  });
  const height = () => page.evaluate(() => ishigaki.session.first.frame.poses[8]);
  const before = await height();
  await page.mouse.move(place.x, place.y);
  await page.mouse.down();
  await page.mouse.move(place.x, place.y - 230, { steps: 4 });
  await page.evaluate(() => {
    for (let i = 0; i < 60; i++) ishigaki.session.step();
  });
  assert.ok((await height()) > before + 0.5, `lifted from ${before} to ${await height()}`);
  await page.mouse.up();
  await page.evaluate(() => {
    for (let i = 0; i < 120; i++) ishigaki.session.step();
  });
  // A cube can come to stand on an edge.
  assert.ok((await height()) < before + 0.25, `it fell down again, to ${await height()}`);
  await close();
});

test('files: a scene and a model are loaded, a bad one is refused with its place', async () => {
  const { page, close } = await live('#scene=tower&n=2&paused=1', { width: 900, height: 600 });
  const drop = (name, text) =>
    page.evaluate(
      ([n, t]) => {
        const transfer = new DataTransfer();
        transfer.items.add(new File([t], n));
        dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, cancelable: true }));
      },
      [name, text],
    );
  const bodies = () => page.evaluate(() => ishigaki.session.first.world.model.bodies.map((b) => b.name));
  await drop('bad.json', '{ "bodies": [{ "shapes": [{ "geometry": { "bal": { "radius": 1 } } }] }] }');
  await page.locator('.toast.error', { hasText: 'bad.json:1:' }).waitFor();
  assert.equal((await bodies()).length, 3, 'the scene that was there stays');
  await drop('ball.json', '{ "name": "one ball", "bodies": [{ "name": "b", "position": [0, 2, 0], "shapes": [{ "geometry": { "ball": { "radius": 0.5 } } }] }] }');
  await page.locator('.toast', { hasText: 'one ball is loaded' }).waitFor();
  assert.deepEqual(await bodies(), ['b']);
  await drop('arm.urdf', '<robot name="arm"><link name="base"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry><sphere radius="0.2"/></geometry></collision></link></robot>');
  await page.locator('.toast', { hasText: 'arm is loaded' }).waitFor();
  assert.ok((await bodies()).includes('base'));
  await drop('noise.bin', '\u0000\u0001 not a scene');
  await page.locator('.toast.error', { hasText: 'noise.bin' }).waitFor();
  await close();
});

test('a wrong link says what is wrong and shows another scene', async () => {
  const { page, close } = await live('#scene=towr', { width: 600, height: 400 });
  await page.locator('.toast.error', { hasText: 'did you mean `tower`' }).waitFor();
  assert.equal((await report(page)).rejected, null);
  await close();
});

test('the picture has a sky, a ground and lit stones; both themes, a phone too', async () => {
  for (const [scheme, size] of [['light', { width: 720, height: 460 }], ['dark', { width: 390, height: 780 }]]) {
    const { page, close } = await live('#scene=wall&paused=1&show=contacts', size, { colorScheme: scheme, quality: 'high' });
    await page.waitForFunction(() => ishigaki.frames > 3);
    const shot = await picture(page, '#stage');
    const [top, middle, bottom] = [shot.region(0, 0.14, 1, 0.18), shot.region(0.2, 0.35, 0.8, 0.7), shot.region(0.3, 0.85, 1, 0.95)];
    assert.equal(top.light > 0.5, scheme === 'light', `the sky is ${scheme}: ${top.light}`);
    assert.ok(middle.spread > 0.05, `stones, shadows and joints differ: ${middle.spread}`);
    assert.ok(Math.abs(bottom.light - middle.light) > 0.005 || bottom.spread > 0.005, 'the ground is not the wall');
    const sideways = await page.evaluate(() => document.documentElement.scrollWidth > innerWidth);
    assert.equal(sideways, false, 'nothing is wider than the window');
    for (const name of ['Scene', 'Solver', 'Plots', 'View']) {
      await page.locator(`[data-tab=${name}]`).click();
      const box = await page.locator('.page:not([hidden])').boundingBox();
      assert.ok(box.width > 280 && box.x >= 0 && box.x + box.width <= size.width + 1, `${name} fits`);
    }
    await close();
  }
});

test('plots and explanations are there for each technique', async () => {
  const { page, close } = await live('#scene=tower&n=4&paused=1', { width: 1000, height: 700 });
  const cards = page.locator('.card');
  await cards.locator('.ask').evaluateAll((buttons) => buttons.forEach((button) => button.click()));
  for (const text of await cards.allInnerTexts()) assert.ok(text.length > 80, `${text} explains itself`);
  for (const explain of await cards.locator('.explain').all()) assert.ok(await explain.isVisible());
  await page.locator('[data-tab=Plots]').click();
  await page.evaluate(() => {
    for (let i = 0; i < 30; i++) ishigaki.session.step();
  });
  await page.waitForFunction(() => document.querySelectorAll('.stage-bar span').length === 10);
  const sweeps = (await report(page)).residual_by_sweep;
  assert.ok(sweeps.length > 1, 'the residual of every sweep is measured');
  for (const plot of await page.locator('canvas.plot').all()) {
    const ink = await plot.evaluate((canvas) => {
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      return data.filter((x, i) => i % 4 === 3 && x > 0).length;
    });
    assert.ok(ink > 300, 'a line is drawn');
  }
  await close();
});

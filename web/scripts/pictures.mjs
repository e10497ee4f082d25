// `npm run pictures`: the screenshots of the README, from the built page, into docs/pictures/.
import { mkdirSync } from 'node:fs';
import { launch, openPage, serve } from '../tests/browser.mjs';

const FOLDER = new URL('../../docs/pictures/', import.meta.url);
const TALK = 'solver:talk&SIDE=solver.substeps:1';
const side = (name) => `${name}=${TALK.replace('SIDE', name)}`;

/** Address, theme, and what to do before the shot. */
const PICTURES = {
  'live-compare': {
    hash: `#scene=tower&n=25&paused=1&${side('a')}&a=solver.weight_amplification.enabled:false&${side('b')}`,
    scheme: 'light',
    prepare: (steps) => {
      for (let i = 0; i < steps; i++) ishigaki.session.step();
    },
    steps: 224,
  },
  'live-wall': {
    hash: '#scene=wall&paused=1',
    scheme: 'dark',
    prepare: (steps) => {
      const { session, stage } = ishigaki;
      document.querySelector('[data-tab=Plots]').click();
      for (let i = 0; i < 20; i++) session.step();
      session.ball = { speed: 38, radius: 0.75, density: 5000 };
      const { left, width, height } = document.querySelector('#stage').getBoundingClientRect();
      session.shoot(stage.ray(left + 0.5 * width, 0.5 * height));
      for (let i = 0; i < steps; i++) session.step();
    },
    steps: 70,
  },
};

mkdirSync(FOLDER, { recursive: true });
const [browser, server] = [await launch(), await serve()];
for (const [name, { hash, scheme, prepare, steps }] of Object.entries(PICTURES)) {
  const size = { width: 1240, height: 720 };
  const { page, problems } = await openPage(browser, `${server.address}/${hash}`, size, { colorScheme: scheme });
  await page.waitForFunction('window.ishigaki');
  await page.evaluate(prepare, steps);
  const drawn = await page.evaluate(() => ishigaki.frames);
  await page.waitForFunction((n) => ishigaki.frames > n + 8, drawn);
  await page.screenshot({ path: new URL(`${name}.png`, FOLDER).pathname, timeout: 120000 });
  if (problems.length > 0) throw new Error(problems.join('\n'));
  console.error(`docs/pictures/${name}.png`);
  await page.close();
}
await browser.close();
server.close();

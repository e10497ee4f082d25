// The live page.

import { brand, h, icon, iconButton, message, short, toast } from '../ui/dom';
import { acceptDrops } from '../ui/files';
import { watchTheme } from '../ui/theme';
import { Stage, type Quality } from '../view/stage';
import { loadEngine, type Engine, type Source } from './engine';
import { openFile } from './files';
import { describe, readLink, shortest, writeLink } from './link';
import { Mouse } from './mouse';
import { Panel } from './panel';
import { OVERLAYS, Session, type Changes } from './session';
import '../ui/style.css';

const KEYS: [key: string, does: string][] = [
  ['Space', 'play or pause'],
  ['.', 'one step'],
  ['R', 'reset'],
  ['F', 'shoot a ball at the pointer'],
  ['C', 'two configurations side by side'],
  ['S / L', 'save / restore a snapshot'],
  ['1 … 6', 'overlays'],
  ['← → ↑ ↓', 'look from another side'],
  ['+ / −', 'nearer, farther'],
  ['P', 'hide or show the panel'],
  ['D', 'dark or light'],
  ['?', 'this list'],
];

/** The talk's techniques in a single substep, without weight amplification and with it: a tower falls, and stands. */
const ONE_SUBSTEP: Changes = [['solver', 'talk'], ['solver.substeps', '1']];
const PICTURE: Changes[] = [[...ONE_SUBSTEP, ['solver.weight_amplification.enabled', 'false']], ONE_SUBSTEP];

class Page {
  private readonly engine: Engine;
  private readonly stage: Stage;
  readonly session: Session;
  private readonly panel: Panel;
  private readonly hud = h('div', { class: 'hud', 'aria-live': 'off' });
  private readonly labels = h('div', { class: 'side-labels' });
  private readonly playButton: HTMLButtonElement;
  private readonly compareButton: HTMLButtonElement;
  private readonly picker: HTMLSelectElement;
  private readonly help: HTMLDialogElement;
  private readonly mouse: Mouse;
  private readonly theme: { toggle: () => void };
  /** Drawn frames. */
  frames = 0;

  constructor(engine: Engine) {
    this.engine = engine;
    const canvas = h('canvas', { id: 'stage', tabindex: 0, 'aria-label': 'The scene: drag bodies to pull them, drag elsewhere to look around' });
    const app = document.querySelector('#app') as HTMLElement;
    const main = h('main', {}, canvas, this.labels, this.hud);
    app.replaceChildren(main);
    const query = new URLSearchParams(location.search);
    this.stage = new Stage(canvas, (query.get('quality') === 'low' ? 'low' : 'high') satisfies Quality);
    this.session = this.open();
    this.mouse = new Mouse(canvas, this.stage, () => this.session);
    this.panel = new Panel(engine, this.session, {
      load: (scene, parameters) => this.load({ scene, parameters }),
      open: (file) => void this.openFile(file),
      compare: (on) => this.compare(on),
    });
    this.picker = h('select', { id: 'scene', 'aria-label': 'Scene' });
    for (const { name, summary } of engine.scenes) {
      this.picker.append(h('option', { value: name, title: summary }, name.replaceAll('_', ' ')));
    }
    this.picker.addEventListener('change', () => this.load({ scene: this.picker.value, parameters: {} }));
    this.playButton = iconButton('play', 'Play or pause (Space)', () => this.play(!this.session.playing));
    this.playButton.classList.add('primary');
    this.compareButton = iconButton('compare', 'Two configurations side by side (C)', () => this.compare(this.session.sides.length < 2), 'Compare');
    this.help = this.helpDialog();
    main.prepend(this.bar());
    app.append(this.panel.element, this.help);
    this.theme = watchTheme((theme) => this.stage.setTheme(theme));
    this.session.onchange = () => this.update();
    this.session.onstep = () => this.panel.plots.add(this.session.sides.map((side) => side.world.report));
    addEventListener('keydown', (event) => this.key(event));
    addEventListener('hashchange', () => this.follow());
    acceptDrops((file) => void this.openFile(file));
    this.update();
    // Only now the canvas has its size.
    this.session.look();
    requestAnimationFrame((now) => this.loop(now, now));
  }

  /** The scene of the address; a wrong address says so and opens another scene. */
  private open(): Session {
    const link = readLink(location.hash, this.engine);
    let session: Session;
    try {
      session = new Session(this.stage, { scene: link.scene, parameters: link.parameters }, link.changes);
    } catch (error) {
      toast(`This link: ${message(error)}`, 'error');
      session = new Session(this.stage, { scene: 'wall', parameters: {} }, [[]]);
    }
    session.colorMode = link.color;
    link.overlays.forEach((name) => session.overlays.add(name));
    session.playing = !link.paused;
    return session;
  }

  /** Another address was typed. */
  private follow(): void {
    if (location.hash === writeLink(this.session, this.engine)) return;
    const link = readLink(location.hash, this.engine);
    this.attempt(() => this.session.load({ scene: link.scene, parameters: link.parameters }, link.changes));
  }

  private bar(): HTMLElement {
    const speed = h('select', { 'aria-label': 'Speed', title: 'Speed' });
    for (const [value, name] of [[1, '1×'], [0.5, '½×'], [0.25, '¼×'], [0.1, '⅒×']] as const) {
      speed.append(h('option', { value }, name));
    }
    speed.addEventListener('change', () => (this.session.speed = Number(speed.value)));
    return h(
      'header',
      { class: 'bar' },
      brand(),
      this.picker,
      h(
        'div',
        { class: 'group' },
        iconButton('reset', 'Reset (R)', () => this.reset()),
        this.playButton,
        iconButton('step', 'One step (.)', () => this.step()),
        speed,
      ),
      h(
        'div',
        { class: 'group' },
        this.compareButton,
        iconButton('ball', 'Shoot a ball (F, or double-click)', () => this.mouse.shootAhead(), 'Shoot'),
      ),
      h(
        'div',
        { class: 'group end' },
        iconButton('link', 'Copy a link to this scene with its settings', () => void this.copyLink()),
        iconButton('sun', 'Dark or light (D)', () => this.theme.toggle()),
        iconButton('help', 'Keys (?)', () => this.help.showModal()),
        iconButton('panel', 'Hide or show the panel (P)', () => this.togglePanel()),
      ),
    );
  }

  private helpDialog(): HTMLDialogElement {
    const dialog = h('dialog', { class: 'help', 'aria-label': 'Keys and mouse' });
    const keys = h('dl', {});
    for (const [key, does] of KEYS) keys.append(h('dt', {}, h('kbd', {}, key)), h('dd', {}, does));
    dialog.append(
      h('h2', {}, 'Keys and mouse'),
      keys,
      h('p', {}, 'Drag a body to pull it, let go to throw it. Drag anything else to look around, right-drag or two fingers to move, wheel or pinch to zoom. Double-click shoots a ball.'),
      h('p', { class: 'hint' }, `Ishigaki ${this.engine.version}. Everything runs in this page; nothing is sent anywhere.`),
      iconButton('close', 'Close', () => dialog.close()),
    );
    return dialog;
  }

  private load(source: Source): void {
    const changes = this.session.sides.map((side) => shortest(side, this.engine));
    this.attempt(() => this.session.load(source, changes));
  }

  private async openFile(file: File): Promise<void> {
    try {
      toast(await openFile(file, this.session));
    } catch (error) {
      toast(message(error), 'error');
    }
  }

  private compare(on: boolean): void {
    const mine = shortest(this.session.sides[0] ?? this.session.first, this.engine);
    const changes = !on ? [mine] : mine.length === 0 ? PICTURE : [[], mine];
    this.attempt(() => this.session.load(this.session.source, changes));
  }

  private attempt(what: () => void): void {
    try {
      what();
    } catch (error) {
      toast(message(error), 'error');
    }
    this.panel.plots.clear();
    this.update();
  }

  private play(on: boolean): void {
    this.session.playing = on;
    this.update();
  }

  private step(): void {
    this.session.playing = false;
    this.session.step();
    this.update();
  }

  private reset(): void {
    this.attempt(() => this.session.reset());
  }

  private togglePanel(): void {
    document.body.classList.toggle('no-panel');
  }

  private async copyLink(): Promise<void> {
    try {
      await navigator.clipboard.writeText(location.href);
      toast('The link is copied');
    } catch {
      toast('The address of this page is the link');
    }
  }

  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    const typing = target.matches('input:not([type=checkbox]), select, textarea');
    if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
    const overlay = OVERLAYS[Number(event.key) - 1];
    const actions: Record<string, () => void> = {
      ' ': () => this.play(!this.session.playing),
      '.': () => this.step(),
      r: () => this.reset(),
      f: () => this.mouse.shootAhead(),
      c: () => this.compare(this.session.sides.length < 2),
      s: () => this.session.save(),
      l: () => this.session.restore(),
      p: () => this.togglePanel(),
      d: () => this.theme.toggle(),
      '?': () => this.help.showModal(),
      arrowleft: () => this.stage.orbit(-0.08, 0, 1),
      arrowright: () => this.stage.orbit(0.08, 0, 1),
      arrowup: () => this.stage.orbit(0, 0.06, 1),
      arrowdown: () => this.stage.orbit(0, -0.06, 1),
      '+': () => this.stage.orbit(0, 0, 0.93),
      '-': () => this.stage.orbit(0, 0, 1.07),
    };
    const action = overlay
      ? (): void => document.querySelector<HTMLInputElement>(`[data-overlay=${overlay.id}]`)?.click()
      : actions[event.key.toLowerCase()];
    if (!action || (event.key === ' ' && target.matches('button, input'))) return;
    event.preventDefault();
    action();
  }

  /** After anything but a step. */
  private update(): void {
    const { session } = this;
    this.panel.update();
    if ('scene' in session.source) this.picker.value = session.source.scene;
    else this.picker.selectedIndex = -1;
    this.playButton.replaceChildren(icon(session.playing ? 'pause' : 'play'));
    this.playButton.setAttribute('aria-pressed', String(session.playing));
    const compared = session.sides.length === 2;
    this.compareButton.setAttribute('aria-pressed', String(compared));
    document.body.classList.toggle('compared', compared);
    this.labels.replaceChildren(
      ...(compared ? session.sides : []).map((side, i) =>
        h('div', { class: `side-label side-${'ab'[i]}` }, h('b', {}, 'AB'[i] ?? ''), describe(shortest(side, this.engine))),
      ),
    );
    const link = writeLink(session, this.engine);
    if (location.hash !== link) history.replaceState(null, '', link);
    this.drawHud();
    document.title = `Ishigaki · ${session.first.world.about.name || 'live'}`;
  }

  private loop(now: number, before: number): void {
    this.session.advance(Math.min((now - before) / 1000, 0.1));
    this.stage.draw();
    this.frames++;
    if (this.frames % 6 === 0) {
      this.drawHud();
      this.panel.drawPlots();
    }
    requestAnimationFrame((next) => this.loop(next, now));
  }

  private drawHud(): void {
    const { session } = this;
    const { report } = session.first.world;
    const slow = session.playing && session.rate < 0.9 * session.speed ? `${short(session.rate)}× real time` : '';
    const words = [
      `${report.time.toFixed(2)} s`,
      `${short(session.first.world.model.bodies.length)} bodies`,
      report.asleep > 0 ? `${short(report.asleep)} asleep` : '',
      `${short(report.contacts)} contacts`,
      `${short(report.rows)} rows`,
      `${short(this.panel.plots.stepTime(0))} ms a step`,
      slow,
      report.non_finite.length > 0 ? `${report.non_finite.length} left the numbers` : '',
    ];
    this.hud.replaceChildren(...words.filter(Boolean).map((word) => h('span', {}, word)));
  }
}

async function start(): Promise<void> {
  try {
    const page = new Page(await loadEngine());
    // For scripts and tests: the running session.
    Object.assign(window, { ishigaki: page });
  } catch (error) {
    const place = document.querySelector('#app');
    place?.replaceChildren(h('p', { class: 'failed', role: 'alert' }, `The page cannot start: ${message(error)}. It needs a browser with WebGL 2 and WebAssembly SIMD.`));
  }
}

void start();

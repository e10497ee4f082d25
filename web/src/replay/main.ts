// The replay page: plays a recording that is inside the page, served beside it, or opened from a disk.

import { acceptDrops, chooseFile } from '../ui/files';
import { gunzip, isGzip, unpack } from '../ui/bytes';
import { brand, h, icon, iconButton, message, short, toast } from '../ui/dom';
import { watchTheme } from '../ui/theme';
import { COLOR_MODES, type ColorMode } from '../view/palette';
import { Stage } from '../view/stage';
import { Recording } from './recording';
import '../ui/style.css';
import './replay.css';

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const MODES = COLOR_MODES.filter(({ id }) => id !== 'speed');

class Player {
  recording: Recording | null = null;
  frame = 0;
  private playing = false;
  private speed = 1;
  private contacts = false;
  private color: ColorMode = 'stone';
  /** Seconds of the recording that are not shown yet. */
  private behind = 0;
  private readonly stage: Stage;
  private readonly playButton = iconButton('play', 'Play or pause (Space)', () => this.play(!this.playing));
  private readonly slider = h('input', { type: 'range', min: 0, max: 0, step: 1, value: 0, 'aria-label': 'Frame' });
  private readonly counter = h('output', { class: 'counter' });
  private readonly hud = h('div', { class: 'hud' });
  private readonly name = h('span', { class: 'recording-name' });
  private readonly contactsButton = h('button', { class: 'button', 'aria-pressed': 'false', title: 'Contacts with normals and λ (1)', onclick: () => this.showContacts(!this.contacts) }, 'Contacts');
  private readonly welcome: HTMLElement;

  constructor() {
    const canvas = h('canvas', { id: 'stage', tabindex: 0, 'aria-label': 'The recorded scene: drag to look around, or use the keys up, down, [, ], + and −' });
    this.welcome = this.makeWelcome();
    const app = document.querySelector('#app') as HTMLElement;
    const query = new URLSearchParams(location.search);
    const main = h('main', {}, canvas, this.hud, this.welcome, this.bar());
    app.append(main, this.transport());
    this.stage = new Stage(canvas, query.get('quality') === 'low' ? 'low' : 'high');
    this.stage.setViews(1);
    const theme = watchTheme((name) => this.stage.setTheme(name));
    this.slider.addEventListener('input', () => this.seek(Number(this.slider.value)));
    addEventListener('keydown', (event) => this.key(event, theme.toggle));
    addEventListener('hashchange', () => this.seekToAddress());
    acceptDrops((file) => void this.open(file));
    this.update();
    requestAnimationFrame((now) => this.loop(now, now));
  }

  private bar(): HTMLElement {
    const color = h('select', { 'aria-label': 'Color of bodies', title: 'Color of bodies' });
    for (const { id, name } of MODES) color.append(h('option', { value: id }, name));
    color.addEventListener('change', () => {
      this.color = color.value as ColorMode;
      this.show();
    });
    const sun = iconButton('sun', 'Dark or light (D)', () => dispatchEvent(new KeyboardEvent('keydown', { key: 'd' })));
    const open = iconButton('open', 'Open a recording', () => chooseFile('.ishi', (file) => void this.open(file)), 'Open');
    return h(
      'header',
      { class: 'bar' },
      brand(),
      this.name,
      h('div', { class: 'group end wide' }, color, this.contactsButton, open, sun),
    );
  }

  private transport(): HTMLElement {
    const speed = h('select', { 'aria-label': 'Speed', title: 'Speed' });
    for (const value of SPEEDS) speed.append(h('option', { value, selected: value === 1 }, `${value}×`));
    speed.addEventListener('change', () => (this.speed = Number(speed.value)));
    this.playButton.classList.add('primary');
    return h(
      'footer',
      { class: 'transport' },
      iconButton('back', 'One frame back (←)', () => this.stepBy(-1)),
      this.playButton,
      iconButton('step', 'One frame on (→)', () => this.stepBy(1)),
      this.slider,
      this.counter,
      speed,
    );
  }

  private makeWelcome(): HTMLElement {
    return h(
      'div',
      { class: 'welcome', hidden: true },
      h('h2', {}, 'Open a recording'),
      h('p', {}, 'Drop an .ishi file here, or choose one. It stays on this machine.'),
      iconButton('open', 'Open a recording', () => chooseFile('.ishi', (file) => void this.open(file)), 'Choose a file'),
      h('p', { class: 'hint' }, 'ishigaki run wall --record wall.ishi makes one.'),
    );
  }

  /** What is inside the page, or beside it; otherwise an invitation. */
  async start(): Promise<void> {
    const inside = document.querySelector('#recording')?.textContent?.trim() ?? '@';
    try {
      if (!inside.startsWith('@')) {
        this.load(await unpack(inside), 'recording');
        return;
      }
      if (location.protocol.startsWith('http')) {
        const answer = await fetch('recording.ishi');
        if (answer.ok) {
          this.load(new Uint8Array(await answer.arrayBuffer()), 'recording.ishi');
          return;
        }
      }
    } catch (error) {
      toast(message(error), 'error');
    }
    this.welcome.hidden = false;
  }

  async open(file: File): Promise<void> {
    try {
      const bytes = new Uint8Array(await file.arrayBuffer());
      this.load(isGzip(bytes) ? await gunzip(bytes) : bytes, file.name);
    } catch (error) {
      toast(message(error), 'error');
    }
  }

  /** Shows a recording; a bad one throws, and what was there stays. */
  load(bytes: Uint8Array, name: string): void {
    let recording: Recording;
    try {
      recording = new Recording(bytes);
    } catch (error) {
      throw new Error(`${name}: ${message(error)}`);
    }
    this.recording = recording;
    if (recording.cut) toast(`${name}: ${recording.cut}; what is there is played`, 'error');
    const { scene } = recording;
    const first = recording.frame(0);
    const around = this.stage.look(scene, first, scene.camera);
    this.stage.views[0]?.show(scene, first, around, scene.options.length_scale ?? 1);
    this.slider.max = String(recording.length - 1);
    this.contactsButton.disabled = !scene.contacts;
    this.contactsButton.title = scene.contacts ? 'Contacts with normals and λ (1)' : 'Recorded without contacts';
    this.welcome.hidden = true;
    this.name.textContent = scene.name;
    document.title = `Ishigaki · ${scene.name}`;
    this.seek(0);
    this.play(!this.seekToAddress());
  }

  /** `#frame=300`; whether the address names a frame. */
  private seekToAddress(): boolean {
    const frame = new URLSearchParams(location.hash.replace(/^#/, '')).get('frame');
    if (frame === null || !this.recording) return false;
    this.seek(Number(frame));
    this.play(false);
    return true;
  }

  private play(on: boolean): void {
    const last = (this.recording?.length ?? 1) - 1;
    if (on && this.frame >= last) this.seek(0);
    this.playing = on && this.recording !== null;
    this.update();
  }

  private stepBy(frames: number): void {
    this.play(false);
    this.seek(this.frame + frames);
  }

  seek(frame: number): void {
    const last = (this.recording?.length ?? 1) - 1;
    this.frame = Math.min(Math.max(Math.round(frame) || 0, 0), last);
    this.behind = 0;
    this.show();
  }

  showContacts(on: boolean): void {
    this.contacts = on && this.recording?.scene.contacts === true;
    this.contactsButton.setAttribute('aria-pressed', String(this.contacts));
    this.show();
  }

  private show(): void {
    const { recording } = this;
    const view = this.stage.views[0];
    if (!recording || !view) return;
    const { scene } = recording;
    view.update(recording.frame(this.frame), this.color);
    view.setOpacity(this.contacts ? 0.55 : 1);
    const weight = Math.hypot(...(scene.options.gravity ?? [0, 9.81, 0])) * scene.dt || 9.81 * scene.dt;
    view.arrows.update(this.contacts ? recording.arrows(this.frame) : new Float32Array(), 0.8 * (scene.options.length_scale ?? 1), weight);
    this.slider.value = String(this.frame);
    const m = recording.measures(this.frame);
    this.counter.textContent = `${this.frame} / ${recording.length - 1}`;
    this.hud.replaceChildren(
      ...[
        `${m.time.toFixed(2)} s`,
        `step ${m.step}`,
        `${short(scene.bodies.length)} bodies`,
        scene.contacts ? `${short(m.contacts)} contacts` : '',
        `energy ${short(m.kinetic + m.potential)} J`,
        `overlap ${short(1000 * m.penetration)} mm`,
      ]
        .filter(Boolean)
        .map((word) => h('span', {}, word)),
    );
  }

  private update(): void {
    this.playButton.replaceChildren(icon(this.playing ? 'pause' : 'play'));
    this.playButton.setAttribute('aria-pressed', String(this.playing));
  }

  private loop(now: number, before: number): void {
    if (this.playing && this.recording) this.advance(Math.min((now - before) / 1000, 0.25), this.recording);
    this.stage.draw();
    requestAnimationFrame((next) => this.loop(next, now));
  }

  private advance(seconds: number, recording: Recording): void {
    this.behind += seconds * this.speed;
    const between = recording.scene.dt * recording.scene.every;
    const frames = Math.floor(this.behind / between);
    if (frames === 0) return;
    this.behind -= frames * between;
    this.frame = Math.min(this.frame + frames, recording.length - 1);
    this.show();
    if (this.frame === recording.length - 1) this.play(false);
  }

  private key(event: KeyboardEvent, theme: () => void): void {
    const target = event.target instanceof HTMLElement ? event.target : null;
    if (event.ctrlKey || event.metaKey || event.altKey || target?.matches('select')) return;
    const last = (this.recording?.length ?? 1) - 1;
    const actions: Record<string, () => void> = {
      ' ': () => this.play(!this.playing),
      ArrowRight: () => this.stepBy(event.shiftKey ? 10 : 1),
      ArrowLeft: () => this.stepBy(event.shiftKey ? -10 : -1),
      Home: () => this.seek(0),
      End: () => this.seek(last),
      ArrowUp: () => this.stage.orbit(0, 0.06, 1),
      ArrowDown: () => this.stage.orbit(0, -0.06, 1),
      '[': () => this.stage.orbit(-0.08, 0, 1),
      ']': () => this.stage.orbit(0.08, 0, 1),
      '+': () => this.stage.orbit(0, 0, 0.93),
      '-': () => this.stage.orbit(0, 0, 1.07),
      '1': () => this.showContacts(!this.contacts),
      d: theme,
    };
    const action = actions[event.key] ?? actions[event.key.toLowerCase()];
    if (!action || (event.key === ' ' && target?.matches('button'))) return;
    event.preventDefault();
    action();
  }
}

const player = new Player();
// For scripts and tests: the running player.
Object.assign(window, { ishigaki: player });
void player.start();

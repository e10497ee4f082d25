// The side panel: scene, techniques, plots, overlays.

import { h, iconButton, message, toast } from '../ui/dom';
import { chooseFile, download } from '../ui/files';
import { COLOR_MODES, REST_COLORS, REST_NAMES, type ColorMode } from '../view/palette';
import { Rest } from '../scene';
import type { Engine, Parameter } from './engine';
import { describe, shortest } from './link';
import { Plots } from './plots';
import { OVERLAYS, type Session } from './session';
import { Techniques } from './techniques';

const TABS = ['Scene', 'Solver', 'Plots', 'View'] as const;
type Tab = (typeof TABS)[number];

/** What the panel asks the page to do. */
export interface Actions {
  load: (scene: string, parameters: Record<string, number>) => void;
  open: (file: File) => void;
  compare: (on: boolean) => void;
}

export class Panel {
  readonly element = h('aside', { class: 'panel', 'aria-label': 'Scene, solver, plots and view' });
  readonly plots = new Plots();
  tab: Tab = 'Solver';
  /** Which configuration the solver tab edits. */
  side = 0;
  private readonly engine: Engine;
  private readonly session: Session;
  private readonly actions: Actions;
  private readonly techniques: Techniques;
  private readonly pages = new Map<Tab, HTMLElement>();
  private readonly buttons = new Map<Tab, HTMLElement>();
  private readonly sides = h('div', { class: 'sides', role: 'radiogroup', 'aria-label': 'Configuration to edit' });
  private readonly scenePage = h('div', { class: 'page' });
  private shownScene = '';

  constructor(engine: Engine, session: Session, actions: Actions) {
    [this.engine, this.session, this.actions] = [engine, session, actions];
    this.techniques = new Techniques(engine.controls, (path, value) => this.set(path, value));
    const presets = h('div', { class: 'presets' }, h('span', {}, 'Preset'));
    for (const preset of ['plain', 'talk', 'default']) {
      presets.append(h('button', { class: 'chip', 'data-preset': preset, onclick: () => this.set('solver', preset) }, preset));
    }
    this.pages.set('Scene', this.scenePage);
    this.pages.set('Solver', h('div', { class: 'page' }, this.sides, presets, this.techniques.element));
    this.pages.set('Plots', h('div', { class: 'page' }, this.plots.element));
    this.pages.set('View', this.viewPage());
    const tabs = h('div', { class: 'tabs', role: 'tablist' });
    for (const tab of TABS) {
      const button = h('button', { role: 'tab', 'data-tab': tab, onclick: () => this.open(tab) }, tab);
      this.buttons.set(tab, button);
      tabs.append(button);
    }
    tabs.addEventListener('keydown', (event) => {
      const turn = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (turn === undefined) return;
      event.stopPropagation();
      const next = TABS[(TABS.indexOf(this.tab) + turn + TABS.length) % TABS.length] ?? 'Solver';
      this.open(next);
      this.buttons.get(next)?.focus();
    });
    this.element.append(tabs, ...this.pages.values());
    this.open(this.tab);
  }

  open(tab: Tab): void {
    this.tab = tab;
    for (const [name, page] of this.pages) page.hidden = name !== tab;
    for (const [name, button] of this.buttons) {
      button.setAttribute('aria-selected', String(name === tab));
      button.tabIndex = name === tab ? 0 : -1;
    }
    if (tab === 'Plots') this.measureSweeps();
  }

  /** The plot of sweeps needs a measurement that is off by default. */
  private measureSweeps(): void {
    this.session.sides.forEach((side, i) => {
      if (side.options.get('report.residual_by_sweep') === 'false') this.session.setOption(i, 'report.residual_by_sweep', 'true');
    });
  }

  private set(path: string, value: string): void {
    try {
      this.session.setOption(this.side, path, value);
    } catch (error) {
      toast(message(error), 'error');
    }
  }

  /** After anything but a step. */
  update(): void {
    const { sides } = this.session;
    this.side = Math.min(this.side, sides.length - 1);
    const side = sides[this.side];
    if (!side) return;
    this.techniques.show(side.options, side.base);
    this.sides.hidden = sides.length < 2;
    this.sides.replaceChildren(
      ...sides.map((_, i) =>
        h(
          'button',
          {
            role: 'radio',
            class: `side side-${'ab'[i]}`,
            'aria-checked': String(i === this.side),
            onclick: () => {
              this.side = i;
              this.update();
            },
          },
          h('b', {}, 'AB'[i] ?? ''),
          describe(shortest(this.session.sides[i] ?? side, this.engine)),
        ),
      ),
    );
    this.updateScene();
    if (this.tab === 'Plots') this.measureSweeps();
  }

  private updateScene(): void {
    const { source } = this.session;
    const saved = this.session.first.saved !== undefined;
    const key = JSON.stringify([source, saved]);
    if (key === this.shownScene) return;
    this.shownScene = key;
    const { about } = this.session.first.world;
    const page = this.scenePage;
    page.replaceChildren(h('p', { class: 'summary' }, about.description || about.name));
    if ('scene' in source) {
      const info = this.engine.scenes.find((s) => s.name === source.scene);
      for (const parameter of info?.parameters ?? []) page.append(this.parameter(parameter, source));
    }
    page.append(
      h('h3', {}, 'Ball to shoot'),
      this.number('speed', 'm/s', () => this.session.ball.speed, (x) => (this.session.ball.speed = x)),
      this.number('radius', 'm', () => this.session.ball.radius, (x) => (this.session.ball.radius = x)),
      this.number('density', 'kg/m³', () => this.session.ball.density, (x) => (this.session.ball.density = x)),
      h('h3', {}, 'State'),
      h(
        'div',
        { class: 'buttons' },
        h('button', { class: 'button', onclick: () => this.save() }, 'Save snapshot'),
        h('button', { class: 'button', disabled: !saved, onclick: () => this.session.restore() }, 'Restore'),
        h('button', { class: 'button', disabled: !saved, onclick: () => this.download() }, 'Download'),
      ),
      h('h3', {}, 'Files'),
      h('p', { class: 'hint' }, 'Drop a scene (.json), a model (.xml, .urdf) or a snapshot anywhere on the page.'),
      h(
        'div',
        { class: 'buttons' },
        iconButton('open', 'Open a file', () => chooseFile('.json,.xml,.mjcf,.urdf,.snap', this.actions.open), 'Open'),
        h('button', { class: 'button', onclick: () => download(`${about.name || 'scene'}.json`, this.session.first.world.file()) }, 'Scene as JSON'),
      ),
    );
    for (const warning of about.warnings) page.append(h('p', { class: 'warning' }, warning));
  }

  private parameter(p: Parameter, source: { scene: string; parameters: Record<string, number> }): HTMLElement {
    const input = h('input', {
      type: 'number',
      id: `parameter-${p.name}`,
      'data-parameter': p.name,
      min: p.least,
      max: p.most,
      step: p.whole ? 1 : 'any',
      value: source.parameters[p.name] ?? p.default,
    });
    input.addEventListener('change', () => this.actions.load(source.scene, { ...source.parameters, [p.name]: Number(input.value) }));
    const unit = [p.doc, p.unit].filter(Boolean).join(', ');
    return h('div', { class: 'row' }, h('label', { for: input.id }, p.name.replaceAll('_', ' '), h('small', {}, unit)), input);
  }

  private number(name: string, unit: string, get: () => number, set: (x: number) => void): HTMLElement {
    const input = h('input', { type: 'number', id: `ball-${name}`, min: 0, step: 'any', value: get() });
    input.addEventListener('change', () => {
      const value = Number(input.value);
      if (Number.isFinite(value) && value > 0) set(value);
      input.value = String(get());
    });
    return h('div', { class: 'row' }, h('label', { for: input.id }, name, h('small', {}, unit)), input);
  }

  private save(): void {
    this.session.save();
    toast('The state is saved: Restore brings it back, bit for bit');
  }

  private download(): void {
    const { saved, world } = this.session.first;
    if (saved) download(`${world.about.name || 'world'}.snap`, saved);
  }

  private viewPage(): HTMLElement {
    const { session } = this;
    const page = h('div', { class: 'page' }, h('h3', {}, 'Color'));
    const colors = h('div', { class: 'choices', role: 'radiogroup', 'aria-label': 'Color of bodies' });
    const legend = h('div', { class: 'legend' });
    const show = (mode: ColorMode): void => {
      session.colorMode = mode;
      for (const button of colors.children) button.setAttribute('aria-checked', String((button as HTMLElement).dataset.color === mode));
      const rests = [Rest.Awake, Rest.Asleep, Rest.Frozen, Rest.Kinematic, Rest.Fixed];
      const doc = COLOR_MODES.find(({ id }) => id === mode)?.doc ?? '';
      legend.replaceChildren(
        ...(mode === 'rest'
          ? rests.map((rest) => h('span', {}, h('i', { style: `background:${REST_COLORS[rest]}` }), REST_NAMES[rest]))
          : [doc]),
      );
      session.refresh();
    };
    for (const { id, name, doc } of COLOR_MODES) {
      const pick = (): void => {
        show(id);
        session.onchange();
      };
      colors.append(h('button', { role: 'radio', class: 'chip', 'data-color': id, title: doc, onclick: pick }, name));
    }
    show(session.colorMode);
    page.append(colors, legend, h('h3', {}, 'Overlays'));
    OVERLAYS.forEach(({ id, name, doc }, i) => {
      const input = h('input', { type: 'checkbox', role: 'switch', 'data-overlay': id, 'aria-label': name });
      input.checked = session.overlays.has(id);
      input.addEventListener('change', () => {
        if (input.checked) session.overlays.add(id);
        else session.overlays.delete(id);
        session.refresh();
        session.onchange();
      });
      const label = h('span', {}, name, doc ? h('small', {}, doc) : null);
      page.append(h('label', { class: 'row overlay' }, label, h('kbd', {}, String(i + 1)), h('span', { class: 'switch' }, input, h('span', {}))));
    });
    return page;
  }

  /** As often as plots are worth drawing. */
  drawPlots(): void {
    if (this.tab === 'Plots') this.plots.draw(this.session.sides.map((side) => side.world.report));
  }
}

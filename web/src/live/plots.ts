// Plots of what the steps report: a line for each configuration.

import { h, short } from '../ui/dom';
import type { Report } from './engine';

/** Steps that are kept. */
const HISTORY = 360;

interface Series {
  title: string;
  unit: string;
  doc: string;
  value: (report: Report) => number;
  log?: boolean;
}

const SERIES: Series[] = [
  { title: 'Energy', unit: 'J', doc: 'Kinetic and potential, against the start', value: (r) => r.kinetic_energy + r.potential_energy },
  { title: 'Kinetic energy', unit: 'J', doc: '', value: (r) => r.kinetic_energy, log: true },
  { title: 'Angular momentum', unit: 'kg·m²/s', doc: '|L| about the origin', value: (r) => Math.hypot(...r.angular_momentum) },
  { title: 'Penetration', unit: 'mm', doc: 'Deepest overlap at the end of the step', value: (r) => 1000 * r.max_penetration },
  { title: 'Residual', unit: 'N·s', doc: '‖λ − clip(λ − w m_eff)‖∞ after the last sweep', value: (r) => r.residual, log: true },
];

const STAGE_COLORS = ['#8d99ae', '#5c7fb0', '#3d6fd6', '#6b5ca5', '#a06cb4', '#c77d9b', '#d9825b', '#c8452c', '#d9a441', '#7fa650'];

class Plot {
  readonly canvas = h('canvas', { class: 'plot', width: 320, height: 84, role: 'img' });
  readonly element: HTMLElement;
  private readonly value = h('span', { class: 'plot-value' });
  private readonly log: boolean;
  private readonly unit: string;
  private readonly title: string;

  constructor(title: string, unit: string, doc: string, log: boolean) {
    this.log = log;
    this.unit = unit;
    this.title = title;
    this.element = h('figure', { title: doc }, h('figcaption', {}, h('b', {}, title), this.value), this.canvas);
  }

  /** One list of numbers for each configuration. */
  draw(lines: number[][], colors: string[]): void {
    const ratio = Math.min(window.devicePixelRatio, 2);
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0) return;
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    const context = this.canvas.getContext('2d');
    if (!context) return;
    context.scale(ratio, ratio);
    const read = (x: number): number => (this.log ? Math.log10(Math.max(x, 1e-9)) : x);
    const all = lines.flat().map(read).filter(Number.isFinite);
    let [low, high] = [Math.min(...all), Math.max(...all)];
    if (all.length === 0) [low, high] = [0, 1];
    // A flat line stays flat: rounding is not blown up to full height.
    const least = this.log ? 0.5 : Math.max(1e-3 * Math.max(Math.abs(low), Math.abs(high)), 1e-9);
    if (high - low < least) [low, high] = [(low + high - least) / 2, (low + high + least) / 2];
    const style = getComputedStyle(this.canvas);
    context.font = '10px ui-monospace, monospace';
    context.fillStyle = style.color;
    context.globalAlpha = 0.75;
    const label = (y: number): string => short(this.log ? 10 ** y : y);
    context.fillText(label(high), 2, 10);
    context.fillText(label(low), 2, height - 3);
    context.globalAlpha = 0.16;
    context.fillRect(0, 0.5, width, 1);
    context.fillRect(0, height - 1, width, 1);
    context.globalAlpha = 1;
    context.lineWidth = 1.6;
    context.lineJoin = 'round';
    const span = Math.max(...lines.map((l) => l.length), 2) - 1;
    lines.forEach((line, i) => {
      context.strokeStyle = colors[i] ?? '#888';
      context.beginPath();
      line.forEach((x, k) => {
        const y = height - 3 - ((read(x) - low) / (high - low)) * (height - 6);
        context.lineTo((k / span) * width, Number.isFinite(y) ? y : 0);
      });
      context.stroke();
    });
    const last = lines.map((line) => short(line.at(-1) ?? NaN)).join(' · ');
    this.value.textContent = `${last} ${this.unit}`;
    this.canvas.setAttribute('aria-label', `${this.title}: ${last} ${this.unit}`);
  }
}

export class Plots {
  readonly element = h('div', { class: 'plots' });
  private readonly history: number[][][] = SERIES.map(() => []);
  private readonly plots = SERIES.map((s) => new Plot(s.title, s.unit, s.doc, s.log ?? false));
  private readonly sweeps = new Plot('Residual by sweep', 'N·s', 'After every sweep of the last step: how fast it converges', true);
  private readonly stages = h('div', { class: 'stages' });
  /** Seconds by stage, smoothed, for each configuration. */
  private readonly times: number[][] = [];

  constructor() {
    this.element.append(this.sweeps.element, ...this.plots.map((p) => p.element));
    this.element.append(h('figure', {}, h('figcaption', {}, h('b', {}, 'Stages of a step')), this.stages));
  }

  clear(): void {
    this.history.forEach((h) => (h.length = 0));
    this.times.length = 0;
  }

  add(reports: Report[]): void {
    SERIES.forEach((series, s) => {
      reports.forEach((report, side) => {
        const line = ((this.history[s] ??= [])[side] ??= []);
        line.push(series.value(report));
        if (line.length > HISTORY) line.shift();
      });
    });
    reports.forEach((report, side) => {
      const smooth = (this.times[side] ??= report.stages.map(() => 0));
      report.stages.forEach(([, seconds], i) => (smooth[i] = (smooth[i] ?? 0) + 0.06 * (seconds - (smooth[i] ?? 0))));
    });
  }

  /** ms of a step, smoothed. */
  stepTime(side: number): number {
    return 1000 * (this.times[side] ?? []).reduce((sum, t) => sum + t, 0);
  }

  draw(reports: Report[]): void {
    const style = getComputedStyle(this.element);
    const colors = ['--side-a', '--side-b'].map((name) => style.getPropertyValue(name).trim());
    this.sweeps.draw(reports.map((r) => r.residual_by_sweep), colors);
    this.plots.forEach((plot, s) => plot.draw(this.history[s] ?? [], colors));
    this.stages.replaceChildren(...reports.map((report, side) => this.bar(report, side, reports.length > 1)));
  }

  private bar(report: Report, side: number, named: boolean): HTMLElement {
    const times = this.times[side] ?? [];
    const total = times.reduce((sum, t) => sum + t, 0);
    const bar = h('div', { class: 'stage-bar' });
    const list = h('ol', {});
    report.stages.forEach(([name], i) => {
      const [part, color] = [total > 0 ? (times[i] ?? 0) / total : 0, STAGE_COLORS[i] ?? '#888'];
      bar.append(h('span', { style: `flex:${part};background:${color}`, title: name }));
      const swatch = h('i', { style: `background:${color}` });
      list.append(h('li', {}, swatch, name, h('span', {}, `${short(1000 * (times[i] ?? 0))} ms`)));
    });
    const title = `${named ? `${'AB'[side]}: ` : ''}${short(1000 * total)} ms`;
    return h('div', {}, h('p', { class: 'stage-total' }, title), bar, list);
  }
}

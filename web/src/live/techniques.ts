// The panel of all options, made from the engine's own list: a card for each technique, a control for each option.

import { h, icon } from '../ui/dom';
import type { Control } from './engine';
import { EXPLANATIONS } from './explain';

interface Card {
  group: string;
  controls: Control[];
}

/** Sets an option of the configuration that is being edited. */
type Set = (path: string, value: string) => void;

/** Options that are a technique of their own, not a number of their group. */
const OWN_CARDS = ['solver.friction', 'solver.permutation'];

export class Techniques {
  readonly element = h('div', { class: 'cards' });
  private readonly controls: Control[];
  private readonly set: Set;
  private readonly readers: ((options: Map<string, string>, base: Map<string, string>) => void)[] = [];

  constructor(controls: Control[], set: Set) {
    this.controls = controls;
    this.set = set;
    for (const card of this.cards()) this.element.append(this.card(card));
  }

  /** Shows these options; marks what differs from the scene's own. */
  show(options: Map<string, string>, base: Map<string, string>): void {
    this.readers.forEach((read) => read(options, base));
  }

  private cards(): Card[] {
    const groups = new Map<string, Control[]>();
    for (const control of this.controls) {
      const own = OWN_CARDS.includes(control.path);
      const group = own ? control.path : control.path.split('.').slice(0, -1).join('.');
      groups.set(group, [...(groups.get(group) ?? []), control]);
    }
    const known = Object.keys(EXPLANATIONS).filter((group) => groups.has(group));
    const unknown = [...groups.keys()].filter((group) => !(group in EXPLANATIONS));
    // New techniques of the engine stand before what is about the world as a whole.
    const solver = known.filter((group) => group.startsWith('solver'));
    const rest = known.filter((group) => !group.startsWith('solver'));
    return [...solver, ...unknown, ...rest].map((group) => ({ group, controls: groups.get(group) ?? [] }));
  }

  private card({ group, controls }: Card): HTMLElement {
    const explanation = EXPLANATIONS[group];
    const name = group.split('.').at(-1) ?? group;
    const title = explanation?.title ?? name.replaceAll('_', ' ').replace(/^./, (c) => c.toUpperCase());
    const enabled = controls.find(({ path }) => path.endsWith('.enabled'));
    const rest = controls.filter((control) => control !== enabled);
    const card = h('section', { class: 'card', 'data-group': group || 'world' });
    const body = h('div', { class: 'card-body' });
    const more = h('div', { class: 'explain', hidden: true });
    const ask = h('button', {
      class: 'ask',
      'aria-expanded': 'false',
      title: `Explain ${title}`,
      'aria-label': `Explain ${title}`,
      onclick: () => {
        more.hidden = !more.hidden;
        ask.setAttribute('aria-expanded', String(!more.hidden));
      },
    });
    ask.append(icon('help'));
    const heading = h('h3', {}, title);
    const head = h('div', { class: 'card-head' }, heading, ask, enabled ? this.toggle(enabled, title) : null);
    more.append(h('p', {}, explanation?.idea ?? controls[0]?.group_doc ?? ''));
    if (explanation?.equation) more.append(h('p', { class: 'equation' }, explanation.equation));
    if (explanation?.without) more.append(h('p', {}, h('b', {}, 'Without it: '), explanation.without));
    if (explanation?.file) more.append(h('p', { class: 'source' }, `crates/ishigaki/src/${explanation.file}`));
    for (const control of rest) body.append(this.row(control, rest.length === 1 && OWN_CARDS.includes(control.path)));
    card.append(head, more, body);
    if (enabled) {
      this.readers.push((options) => card.classList.toggle('off', options.get(enabled.path) === 'false'));
    }
    return card;
  }

  private toggle(control: Control, label: string): HTMLElement {
    const input = h('input', { type: 'checkbox', role: 'switch', 'data-path': control.path, 'aria-label': label });
    input.addEventListener('change', () => this.set(control.path, String(input.checked)));
    this.readers.push((options) => (input.checked = options.get(control.path) === 'true'));
    return h('label', { class: 'switch', title: control.doc }, input, h('span', {}));
  }

  private row(control: Control, bare: boolean): HTMLElement {
    const name = control.path.split('.').at(-1)?.replaceAll('_', ' ') ?? control.path;
    const field = this.field(control, name);
    const row = h('div', { class: 'row', title: control.doc }, bare ? null : h('label', { for: id(control) }, name), field);
    this.readers.push((options, base) => row.classList.toggle('changed', options.get(control.path) !== base.get(control.path)));
    return row;
  }

  private field(control: Control, name: string): HTMLElement {
    if (control.kind === 'switch') return this.toggle(control, name);
    if (typeof control.kind === 'object') {
      const select = h('select', { id: id(control), 'data-path': control.path, 'aria-label': name });
      for (const [choice, doc] of control.kind.choice) {
        select.append(h('option', { value: choice, title: doc }, choice.replaceAll('_', ' ')));
      }
      select.addEventListener('change', () => this.set(control.path, select.value));
      this.readers.push((options) => (select.value = options.get(control.path) ?? ''));
      return select;
    }
    const numeric = control.kind !== 'vector';
    const input = h('input', {
      id: id(control),
      'data-path': control.path,
      type: numeric ? 'number' : 'text',
      step: control.kind === 'whole' ? 1 : 'any',
      min: numeric ? 0 : undefined,
      spellcheck: 'false',
    });
    input.addEventListener('change', () => this.set(control.path, input.value));
    this.readers.push((options) => {
      if (document.activeElement !== input || !input.matches(':invalid')) input.value = options.get(control.path) ?? '';
    });
    // Ranges are in the engine's words.
    if (!/in \[0, 1\]/.test(control.doc)) return input;
    const slider = h('input', { type: 'range', min: 0, max: 1, step: 0.01, 'aria-label': name, tabindex: -1 });
    slider.addEventListener('input', () => this.set(control.path, slider.value));
    this.readers.push((options) => (slider.value = options.get(control.path) ?? '0'));
    return h('span', { class: 'pair' }, slider, input);
  }
}

function id(control: Control): string {
  return `option-${control.path.replaceAll('.', '-')}`;
}

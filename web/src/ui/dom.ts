// Elements in one expression.

type Child = Node | string | null | undefined | false;

type Attributes = Record<string, string | number | boolean | undefined | ((event: never) => void)>;

/** `h('button', { class: 'x', onclick: f }, 'text')`; `true` sets an empty attribute, `false` none. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    if (typeof value === 'function') element.addEventListener(name.replace(/^on/, ''), value as EventListener);
    else element.setAttribute(name, value === true ? '' : String(value));
  }
  element.append(...children.filter((c): c is Node | string => c !== null && c !== undefined && c !== false));
  return element;
}

const ICONS = {
  play: '<path d="M7 4.5v15l12-7.5z" fill="currentColor" stroke="none"/>',
  pause: '<path d="M7 5h3.6v14H7zM13.4 5H17v14h-3.6z" fill="currentColor" stroke="none"/>',
  step: '<path d="M5 5v14l9-7z" fill="currentColor" stroke="none"/><path d="M17.5 5v14"/>',
  back: '<path d="M19 5v14l-9-7z" fill="currentColor" stroke="none"/><path d="M6.5 5v14"/>',
  reset: '<path d="M5 12a7 7 0 1 0 2.2-5.1"/><path d="M4.5 4.500v4h4"/>',
  compare: '<rect x="3.5" y="5" width="17" height="14" rx="2"/><path d="M12 5v14"/>',
  ball: '<circle cx="15.5" cy="12" r="4.5"/><path d="M3 9h5M2 12h5M3 15h5"/>',
  link: '<path d="M10 14a4 4 0 0 0 5.7 0l3-3a4 4 0 0 0-5.7-5.700l-1 1"/><path d="M14 10a4 4 0 0 0-5.7 0l-3 3a4 4 0 0 0 5.7 5.700l1-1"/>',
  sun: '<circle cx="12" cy="12" r="4"/><path d="M12 3v2M12 19v2M3 12h2M19 12h2M5.6 5.600l1.4 1.400M17 17l1.4 1.400M5.6 18.4 7 17M17 7l1.4-1.4"/>',
  panel: '<rect x="3.5" y="5" width="17" height="14" rx="2"/><path d="M14.5 5v14"/>',
  open: '<path d="M4 18V6.500A1.5 1.5 0 0 1 5.5 5H9l2 2.500h7.500A1.5 1.5 0 0 1 20 9v9a1.5 1.5 0 0 1-1.5 1.500h-13A1.5 1.5 0 0 1 4 18z"/>',
  help: '<circle cx="12" cy="12" r="8.5"/><path d="M9.6 9.500a2.5 2.5 0 1 1 3.4 2.600c-.7.3-1 .8-1 1.6"/><path d="M12 16.500v.1"/>',
  close: '<path d="M6 6l12 12M18 6 6 18"/>',
};

export type Icon = keyof typeof ICONS;

/** The mark: stones that hold each other. */
export function brand(): HTMLHeadingElement {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  svg.innerHTML =
    '<path d="M7.5 3.500h7.200l.9 5.200H6.300z"/><path d="M4.2 10.200h6.600l.5 4.9-7.6.4z"/><path d="M12.3 10.200h6.600l1.3 5.3-7.4-.4z"/><path d="M2.5 16.900l9.3-.4 1.5 4.400H2z"/><path d="M13.3 16.500l7.7.4.9 4h-7.200z"/>';
  return h('h1', { class: 'brand' }, svg, 'Ishigaki');
}

export function icon(name: Icon): SVGSVGElement {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 24 24');
  svg.setAttribute('aria-hidden', 'true');
  svg.innerHTML = ICONS[name];
  return svg;
}

/** A button with an icon; its label is for tooltips and screen readers. */
export function iconButton(name: Icon, label: string, onclick: () => void, text?: string): HTMLButtonElement {
  const button = h('button', { class: text ? 'button' : 'button icon-only', title: label, 'aria-label': label, onclick });
  button.append(icon(name));
  if (text) button.append(h('span', {}, text));
  return button;
}

/** A note at the bottom of the page; errors stay until they are closed. */
export function toast(message: string, kind: 'info' | 'error' = 'info'): void {
  let tray = document.querySelector('.toasts');
  if (!tray) document.body.append((tray = h('div', { class: 'toasts', 'aria-live': 'assertive' })));
  const note = h('div', { class: `toast ${kind}`, role: kind === 'error' ? 'alert' : 'status' }, h('span', {}, message));
  note.append(iconButton('close', 'Close this note', () => note.remove()));
  tray.append(note);
  while (tray.childElementCount > 3) tray.firstElementChild?.remove();
  if (kind === 'info') setTimeout(() => note.remove(), 3500);
}

export function message(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

/** Three digits, thin spaces between thousands. */
export function short(x: number): string {
  if (!Number.isFinite(x)) return '–';
  const size = Math.abs(x);
  if (size === 0) return '0';
  if (size >= 1e6 || size < 1e-3) return x.toExponential(1);
  if (size >= 1000) return Math.round(x).toLocaleString('en').replace(/,/g, '\u2009');
  return String(Number(x.toPrecision(3)));
}

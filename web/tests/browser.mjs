// A real browser and a server for the built pages.
import { createServer } from 'node:http';
import { existsSync, readFileSync } from 'node:fs';
import { chromium } from 'playwright-core';

const PATHS = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];

export function chromiumPath() {
  return PATHS.find((path) => path && existsSync(path));
}

/** Chromium with WebGL by software: the same picture on every machine. */
export async function launch() {
  return chromium.launch({
    executablePath: chromiumPath(),
    args: [
      '--no-sandbox',
      '--use-gl=angle',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
    ],
  });
}

const TYPES = { json: 'application/json', ishi: 'application/octet-stream' };

/** Serves web/dist and `extra` (path to bytes) on loopback; anything else is 404. */
export async function serve(extra = {}) {
  const server = createServer((request, response) => {
    const path = decodeURIComponent(new URL(request.url, 'http://x').pathname).replace(/^\/$/, '/index.html');
    const file = new URL(`../dist${path}`, import.meta.url);
    const body = extra[path] ?? (!path.includes('..') && existsSync(file) ? readFileSync(file) : null);
    response.writeHead(body ? 200 : 404, { 'content-type': TYPES[path.split('.').at(-1)] ?? 'text/html; charset=utf-8' });
    response.end(body ?? 'not found');
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  return { address: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

/** A page that collects what goes wrong: console errors, exceptions, requests to anywhere else. */
export async function openPage(browser, address, size = { width: 900, height: 600 }, options = {}) {
  const page = await browser.newPage({ viewport: size, ...options });
  const problems = [];
  const server = new URL(address).origin;
  page.on('console', (message) => {
    if (message.type() === 'error') problems.push(message.text());
  });
  page.on('pageerror', (error) => problems.push(String(error)));
  page.on('request', (request) => {
    if (!/^(data|blob):/.test(request.url()) && !request.url().startsWith(server)) problems.push(`asks for ${request.url()}`);
  });
  await page.goto(address);
  return { page, problems };
}

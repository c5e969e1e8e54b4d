// A headless Chromium, for tests that use the pages as a person would. No test sleeps: they wait for what they expect,
// and fail when it does not come.
import axe from 'axe-core';
import assert from 'node:assert/strict';
import { existsSync } from 'node:fs';
import { setTimeout } from 'node:timers/promises';
import { isDeepStrictEqual } from 'node:util';
import puppeteer, { type Browser, type LaunchOptions, type Page, type SerializedAXNode } from 'puppeteer-core';

import type { Role } from '../../src/shared/protocol';
import { StandInServer } from '../stand_in_server';
import { WebKitPage } from './webkit';

// ROOMWISE_BROWSER=firefox: the same tests in Firefox, by WebDriver BiDi; webkit: those of the phone's page in WebKitGTK, by WebDriver,
// where there is a display (xvfb-run).
const kBrowser = process.env['ROOMWISE_BROWSER'] ?? 'chromium';
export const kIsFirefox = kBrowser === 'firefox';
export const kIsWebKit = kBrowser === 'webkit';
const kKinds: Record<string, { variable: string; package: string; lens: string; places: string[] }> = {
  chromium: {
    variable: 'ROOMWISE_CHROMIUM', package: 'chromium', lens: 'fake_device_0',
    places: ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'],
  },
  firefox: {
    variable: 'ROOMWISE_FIREFOX', package: 'firefox-esr', lens: 'Default Video Device', places: ['/usr/bin/firefox-esr', '/usr/bin/firefox'],
  },
  webkit: {
    variable: 'ROOMWISE_WEBKIT', package: 'webkit2gtk-driver', lens: 'Mock video device 2',
    places: ['x86_64', 'aarch64'].map((machine) => `/usr/lib/${machine}-linux-gnu/webkit2gtk-4.1/MiniBrowser`),
  },
};
const kKind = kKinds[kBrowser];
assert.ok(kKind, `ROOMWISE_BROWSER is '${kBrowser}'; chromium, firefox or webkit`);
export const kPages = process.env['ROOMWISE_WEB'] ?? '';
export const kPhone = { width: 360, height: 740 };
export const kDesktop = { width: 1280, height: 900 };
export const kPatience = 120_000; // ms; on a busy machine
const kTags = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'];

function program(): string | null {
  const { variable, places } = kKind as (typeof kKinds)[string];
  return [process.env[variable] ?? '', ...places].find((place) => place !== '' && existsSync(place)) ?? null;
}

// For `test(name, {skip: skipReason}, ...)`.
export const skipReason: string | false = program() === null
  && `no ${kBrowser} found: install it (apt-get install ${kKind.package}), or name the program in ${kKind.variable}`;
// As the browser calls its made-up camera.
export const kFakeLens = kKind.lens;
// Of tests of what other browsers do not have, or do not tell.
export function onlyInChromium(why: string): string | false {
  return skipReason || ((kIsFirefox || kIsWebKit) && `not in ${kBrowser}: ${why}`);
}

// A made-up camera and microphone, nobody asked for them; movements reduced.
const kPreferences = {
  'media.navigator.streams.fake': true, 'media.navigator.permission.disabled': true, 'media.autoplay.default': 0,
  'ui.prefersReducedMotion': 1, 'intl.accept_languages': 'en-US', 'intl.locale.requested': 'en-US',
};

// By the clock and not by drawing, which a page in the background does not do.
export const kWaiting = { polling: 100 } as const;

// Waits until a condition of the stand-in holds.
export async function until(holds: () => boolean): Promise<void> {
  const given = Date.now() + kPatience;
  const holdsNow = (): boolean => {
    try {
      return holds();
    } catch {
      return false; // the page connects anew
    }
  };
  while (!holdsNow() && Date.now() < given) {
    await setTimeout(1);
  }
  assert.ok(holds(), 'the computer did not get what it waits for');
}

// Waits until the stand-in got what was expected: the page may still be sending it when it shows the next thing.
export async function gets<T>(got: () => T, expected: T, words?: string): Promise<void> {
  await until(() => isDeepStrictEqual(got(), expected)).catch(() => assert.deepEqual(got(), expected, words));
}

export function launchBrowser(more: LaunchOptions = {}): Promise<Browser> {
  if (kIsFirefox) {
    return puppeteer.launch({
      ...more,
      browser: 'firefox',
      executablePath: program() ?? '',
      args: [],
      extraPrefsFirefox: kPreferences,
      timeout: kPatience,
      protocolTimeout: 300_000,
    });
  }
  return puppeteer.launch({
    ...more,
    executablePath: program() ?? '',
    args: [
      '--no-sandbox', '--use-fake-device-for-media-stream', '--use-fake-ui-for-media-stream', '--disable-gpu',
      '--enable-unsafe-swiftshader', '--autoplay-policy=no-user-gesture-required', '--lang=en-US',
      // Two people have two screens: neither page is a hidden one.
      '--disable-backgrounding-occluded-windows', '--disable-renderer-backgrounding', '--disable-background-timer-throttling',
      ...(more.args ?? []),
    ],
    timeout: kPatience,
    protocolTimeout: 300_000,
  });
}

let browser: Promise<Browser> | null = null;
function sharedBrowser(): Promise<Browser> {
  browser ??= launchBrowser();
  return browser;
}

export async function closeBrowser(): Promise<void> {
  WebKitPage.closeAll();
  await (await browser)?.close();
  browser = null;
}

export interface PageOptions {
  size?: { width: number; height: number };
  dark?: boolean;
  guarded?: boolean; // false: requests are not looked at, since that would go round the service worker
  before?: (() => void) | (() => void)[]; // run in the page before its own scripts
}

export interface OpenOptions extends PageOptions {
  role?: Role; // as which the browser is paired already
}

export class Visit {
  readonly outside: string[] = [];
  readonly failures: string[] = [];
  readonly requests: string[] = []; // their addresses
  bytes = 0;

  constructor(readonly page: Page, readonly url: string) {}

  async go(path: string): Promise<void> {
    await this.page.goto(this.url + path, { waitUntil: 'load' });
  }

  // Waits until an element that fits holds the words.
  async sees(words: string, selector = 'body', timeout = kPatience): Promise<void> {
    await this.page.waitForFunction(
      (wanted, where) => [...document.querySelectorAll(where)].some((one) => (one as HTMLElement).innerText?.includes(wanted)),
      { ...kWaiting, timeout }, words, selector,
    ).catch(async () => {
      const there = await this.page.evaluate((where) => [...document.querySelectorAll(where)].map((one) => (one as HTMLElement).innerText).join('\n---\n'), selector);
      assert.fail(`'${words}' did not come into ${selector}, which holds:\n${there}`);
    });
  }

  // What live regions were given so far, in order: what a screen reader would read by itself.
  async announced(): Promise<string[]> {
    return this.page.evaluate(() => (window as unknown as { announced: string[] }).announced);
  }

  async hears(words: string, timeout = kPatience): Promise<void> {
    await this.page.waitForFunction(
      (wanted) => (window as unknown as { announced: string[] }).announced.some((one) => one.includes(wanted)),
      { ...kWaiting, timeout }, words,
    ).catch(async () => assert.fail(`'${words}' was not announced; only: ${JSON.stringify(await this.announced())}`));
  }

  // Presses Tab until the control of this name has the focus.
  async tabTo(name: string, most = 160): Promise<void> {
    const place = await this.page.waitForFunction(
      (wanted) => {
        const found = [...document.querySelectorAll<HTMLElement>('a, button, input, select, textarea, summary, [tabindex]')]
          .find((one) => [one.getAttribute('aria-label'), (one as HTMLInputElement).labels?.[0]?.innerText, one.innerText]
            .some((words) => (words ?? '').replace(/\s+/g, ' ').trim() === wanted));
        const here = document.activeElement ?? document.body;
        return found && (found === here ? 'here' : here.compareDocumentPosition(found) & Node.DOCUMENT_POSITION_PRECEDING ? 'before' : 'behind');
      },
      { ...kWaiting, timeout: kPatience }, name,
    ).catch(() => assert.fail(`there is no control '${name}' on the page`));
    // Elsewhere than in Chromium the way round from the last control to the first leads through the browser's own, from which keys do not come back here.
    const where = await place.jsonValue();
    if (where === 'here') {
      return;
    }
    const isBack = (kIsFirefox || kIsWebKit) && where === 'before';
    const passed: string[] = [];
    for (let i = 0; i < most; i += 1) {
      await (isBack ? this.tabBack() : this.page.keyboard.press('Tab'));
      const here = await this.focused();
      if (here === name) {
        return;
      }
      passed.push(here);
    }
    assert.fail(`Tab does not lead to '${name}'; it leads to ${JSON.stringify(passed)}`);
  }

  private async tabBack(): Promise<void> {
    await this.page.keyboard.down('Shift');
    await this.page.keyboard.press('Tab');
    await this.page.keyboard.up('Shift');
  }

  // The name of what has the focus: of its aria-label, its label, or its own words.
  async focused(): Promise<string> {
    return this.page.evaluate(() => {
      const element = document.activeElement as HTMLElement | null;
      const labels = (element as HTMLInputElement | null)?.labels;
      const words = element?.getAttribute('aria-label') ?? (labels && labels[0] ? labels[0].innerText : element?.innerText);
      return (words ?? '').replace(/\s+/g, ' ').trim();
    });
  }

  // All static texts of the accessibility tree; where the browser does not hand it out, all that is shown and not hidden from it.
  async accessibleTexts(): Promise<string[]> {
    if (kIsFirefox || kIsWebKit) {
      return this.page.evaluate(() => {
        const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
        const texts: string[] = [];
        while (walker.nextNode()) {
          const element = walker.currentNode.parentElement;
          if (element?.checkVisibility({ visibilityProperty: true }) && !element.closest('[aria-hidden=true]')) {
            texts.push(walker.currentNode.textContent ?? '');
          }
        }
        return texts;
      });
    }
    const found: string[] = [];
    const walk = (node: SerializedAXNode | null | undefined): void => {
      if (node?.role === 'StaticText') {
        found.push(node.name ?? '');
      }
      node?.children?.forEach(walk);
    };
    walk(await this.page.accessibility.snapshot({ interestingOnly: false }));
    return found;
  }

  async press(name: string): Promise<void> {
    await this.tabTo(name);
    await this.page.keyboard.press('Enter');
  }

  async type(words: string): Promise<void> {
    await this.page.keyboard.type(words);
  }

  async assertAccessible(what: string): Promise<void> {
    if (!(await this.page.evaluate(() => 'axe' in window))) {
      await this.page.evaluate(axe.source);
    }
    const found = await this.page.evaluate(async (tags) => {
      const results = await (window as unknown as { axe: typeof axe }).axe.run(document, { runOnly: tags });
      return results.violations.map((one) => `${one.id}: ${one.help}\n  ${one.nodes.map((node) => node.html + '\n    ' + node.failureSummary).join('\n  ')}`);
    }, kTags);
    assert.deepEqual(found, [], `axe-core on ${what}`);
  }

  async assertReflows(): Promise<void> {
    const over = await this.page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    assert.ok(over <= 0, `the page is ${over} px wider than the window`);
  }

  async close(): Promise<void> {
    if (kIsWebKit) {
      this.failures.push(...await this.page.evaluate(() => (window as unknown as { errors?: string[] }).errors ?? []));
      await this.page.close();
    } else {
      await this.page.browserContext().close(); // with its service worker and its sockets
    }
    assert.deepEqual(this.outside, [], 'requests that leave the home');
    assert.deepEqual(this.failures, [], 'errors in the page');
  }
}

export async function withServer(run: (server: StandInServer) => Promise<void>): Promise<void> {
  const server = new StandInServer(kPages);
  await server.start();
  try {
    await run(server);
  } finally {
    await server.stop();
  }
}

export async function openVisit(server: StandInServer, options: OpenOptions = {}): Promise<Visit> {
  if (kIsWebKit) {
    return openInWebKit(server, options);
  }
  const visit = await openPage(await sharedBrowser(), server.url, options);
  if (options.role) {
    await visit.page.browserContext().setCookie({
      name: 'roomwise', value: server.state.pair(options.role), domain: 'localhost', path: '/', secure: true, httpOnly: true,
      sameSite: 'Strict',
    });
  }
  return visit;
}

// Opens a browser window of its own: cookies and storage begin empty.
export async function openPage(where: Browser, url: string, options: PageOptions = {}): Promise<Visit> {
  const context = await where.createBrowserContext();
  const page = await context.newPage();
  page.setDefaultTimeout(kPatience);
  page.setDefaultNavigationTimeout(kPatience);
  const visit = new Visit(page, url);
  await page.setViewport({ ...(options.size ?? kDesktop), hasTouch: options.size === kPhone });
  if (!kIsFirefox) { // there it is light, and its preferences reduce movements
    await page.emulateMediaFeatures([
      { name: 'prefers-color-scheme', value: options.dark ? 'dark' : 'light' },
      { name: 'prefers-reduced-motion', value: 'reduce' },
    ]);
  }
  await page.evaluateOnNewDocument(listenToLiveRegions);
  for (const run of [options.before ?? []].flat()) {
    await page.evaluateOnNewDocument(run);
  }
  if (options.guarded !== false) {
    await guard(visit);
  }
  return visit;
}

async function openInWebKit(server: StandInServer, options: OpenOptions): Promise<Visit> {
  server.before = [keepErrors, holdDevices, listenToLiveRegions, ...[options.before ?? []].flat()].map((run) => `(${run.toString()})();`).join('\n');
  const page = await WebKitPage.open(program() ?? '', options.size ?? kDesktop, kPatience);
  if (options.role) {
    await page.goto(`${server.url}/manifest.webmanifest`); // a cookie is given to the page that is open
    await page.setCookie({ name: 'roomwise', value: server.state.pair(options.role), domain: 'localhost', path: '/', httpOnly: true, sameSite: 'Strict' });
  }
  return new Visit(page as unknown as Page, server.url);
}

// What the page's console would say, where nothing else tells it. It runs in the page.
function keepErrors(): void {
  const errors: string[] = [];
  (window as unknown as { errors: string[] }).errors = errors;
  window.addEventListener('error', (event) => errors.push(event.message));
  window.addEventListener('unhandledrejection', (event) => errors.push(String(event.reason)));
}

// WebKit forgets what is set on an object that nobody holds. It runs in the page.
function holdDevices(): void {
  (window as unknown as { devices: MediaDevices }).devices = navigator.mediaDevices;
}

async function guard(visit: Visit): Promise<void> {
  const { page, url } = visit;
  await page.setRequestInterception(true);
  page.on('request', (request) => {
    visit.requests.push(request.url());
    const own = [url + '/', url.replace('http', 'ws') + '/', 'blob:', 'data:'];
    if (own.some((start) => request.url().startsWith(start))) {
      void request.continue();
    } else {
      visit.outside.push(request.url());
      void request.abort();
    }
  });
  // A computer that is away, and refusals that a test asks for, are in the browser's log by themselves.
  const usual = kIsFirefox ? /connection to the server at|connection to .* was interrupted|NetworkError/
    : /ERR_CONNECTION|WebSocket|status of (4\d\d|503)/;
  const failed = (words: string): void => void (usual.test(words) || visit.failures.push(words));
  page.on('pageerror', (error) => failed(String(error)));
  page.on('console', (message) => message.type() === 'error' && failed(message.text()));
  if (kIsFirefox) {
    return; // it does not count bytes
  }
  const network = await page.createCDPSession();
  await network.send('Network.enable');
  network.on('Network.loadingFinished', (event) => (visit.bytes += event.encodedDataLength));
}

// Keeps what comes into live regions. A dialog that is open puts all else out of a screen reader's reach, and what goes with
// its region as soon as it came is not read. It runs in the page.
function listenToLiveRegions(): void {
  const heard: string[] = [];
  (window as unknown as { announced: string[] }).announced = heard;
  const regionOf = (node: Node): Element | null => {
    const element = node instanceof Element ? node : node.parentElement;
    return element?.closest('[aria-live], [role=alert], [role=status], [role=log]') ?? null;
  };
  const isReached = (region: Element): boolean => {
    const dialog = [...document.querySelectorAll('dialog:modal')].pop() ?? document;
    return dialog.contains(region) && region.getAttribute('aria-live') !== 'off';
  };
  let fresh: { words: string; region: Element }[] = []; // of this task
  new MutationObserver((changes) => {
    for (const { words } of fresh.filter(({ region }) => !isReached(region))) {
      heard.splice(heard.lastIndexOf(words), 1);
    }
    fresh = fresh.filter(({ region }) => isReached(region));
    for (const { target, addedNodes } of changes) {
      for (const node of addedNodes) {
        const words = (node.textContent ?? '').trim();
        const region = regionOf(target);
        if (words !== '' && region && isReached(region)) {
          heard.push(words);
          fresh.push({ words, region });
        }
      }
    }
    window.setTimeout(() => (fresh = []), 0);
  }).observe(document, { childList: true, subtree: true });
}

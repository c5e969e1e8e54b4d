// A window of WebKitGTK's MiniBrowser, driven by W3C WebDriver, with those parts of a puppeteer Page that the tests of the phone's
// page use. WebDriver cannot run a script before a page's own: the stand-in server serves it (`before`).
import { spawn, type ChildProcess } from 'node:child_process';
import { createServer, type AddressInfo } from 'node:net';
import { setTimeout } from 'node:timers/promises';

const kElement = 'element-6066-11e4-a52e-4f735466cecf'; // as the standard calls a reference to one
const kKeys: Record<string, string> = {
  Backspace: '\ue003', Tab: '\ue004', Enter: '\ue007', Shift: '\ue008', Control: '\ue009', Escape: '\ue00c', ArrowLeft: '\ue012', ArrowUp: '\ue013',
  ArrowRight: '\ue014', ArrowDown: '\ue015', End: '\ue010', Home: '\ue011', Space: ' ',
};
type InPage<A extends unknown[], R> = ((...given: A) => R | Promise<R>) | string;
interface Cookie { name: string; value: string; domain: string; path: string; httpOnly: boolean; sameSite: string }

export class WebKitPage {
  readonly keyboard = {
    down: (key: string): Promise<void> => this.keys([{ type: 'keyDown', value: kKeys[key] ?? key }]),
    up: (key: string): Promise<void> => this.keys([{ type: 'keyUp', value: kKeys[key] ?? key }]),
    press: (key: string): Promise<void> => this.type([kKeys[key] ?? key]),
    type: (words: string): Promise<void> => this.type([...words]),
  };

  private static readonly drivers = new Set<ChildProcess>();

  private constructor(private readonly driver: ChildProcess, private readonly address: string, private readonly patience: number) {}

  // A window of its own: cookies and storage begin empty, as the browser keeps none where it is driven.
  static async open(binary: string, size: { width: number; height: number }, patience: number): Promise<WebKitPage> {
    const port = await freePort();
    const driver = spawn('WebKitWebDriver', [`--port=${port}`], { stdio: 'ignore' });
    WebKitPage.drivers.add(driver);
    const failed = new Promise<never>((_, reject) => driver.once('error', (error) => reject(new Error(
      `WebKitWebDriver does not start (${error.message}): install it (apt-get install webkit2gtk-driver)`))));
    const begun = session(`http://127.0.0.1:${port}`, binary, patience);
    const id = await Promise.race([begun, failed]);
    const page = new WebKitPage(driver, `http://127.0.0.1:${port}/session/${id}`, patience);
    await page.call('POST', '/timeouts', { script: patience, pageLoad: patience });
    await page.resize(size);
    return page;
  }

  async goto(url: string): Promise<void> {
    await this.call('POST', '/url', { url });
  }

  async reload(): Promise<void> {
    await this.call('POST', '/refresh', {});
  }

  async url(): Promise<string> {
    return await this.call('GET', '/url') as string;
  }

  // Of words: statements, without a value.
  async evaluate<A extends unknown[], R>(what: InPage<A, R>, ...given: A): Promise<R> {
    return this.run(typeof what === 'string' ? `(() => {${what}\n})()` : `(${what.toString()})(...given)`, given);
  }

  async waitForFunction<A extends unknown[], R>(
    what: InPage<A, R>, { timeout = this.patience, polling = 100 }: { timeout?: number; polling?: number } = {}, ...given: A
  ): Promise<{ jsonValue: () => Promise<R> }> {
    for (const end = Date.now() + timeout; ;) {
      const value = await this.evaluate(what, ...given);
      if (value) {
        return { jsonValue: () => Promise.resolve(value) };
      }
      if (Date.now() > end) {
        throw new Error(`did not become so within ${timeout} ms`);
      }
      await setTimeout(polling);
    }
  }

  async waitForSelector(selector: string): Promise<{ focus: () => Promise<void> }> {
    await this.waitForFunction((which: string) => document.querySelector(which) !== null, {}, selector);
    return { focus: () => this.focus(selector) };
  }

  // Begun before what leads to another page.
  async waitForNavigation(): Promise<void> {
    await this.evaluate(() => void ((window as unknown as { left: boolean }).left = false));
    await this.waitForFunction(() => !('left' in window) && document.readyState === 'complete');
  }

  async $eval<A extends unknown[], R>(selector: string, what: (one: Element, ...given: A) => R, ...given: A): Promise<R> {
    return this.run(`(${what.toString()})(document.querySelector(given.shift()), ...given)`, [selector, ...given]);
  }

  async $$eval<A extends unknown[], R>(selector: string, what: (all: Element[], ...given: A) => R, ...given: A): Promise<R> {
    return this.run(`(${what.toString()})([...document.querySelectorAll(given.shift())], ...given)`, [selector, ...given]);
  }

  async click(selector: string): Promise<void> {
    const found = await this.call('POST', '/element', { using: 'css selector', value: selector }) as Record<string, string>;
    await this.call('POST', `/element/${found[kElement]}/click`, {});
  }

  async focus(selector: string): Promise<void> {
    await this.$eval(selector, (one) => (one as HTMLElement).focus());
  }

  async setCookie({ name, value, path, httpOnly, sameSite }: Cookie): Promise<void> {
    await this.call('POST', '/cookie', { cookie: { name, value, path, httpOnly, sameSite } }); // not "secure": the stand-in speaks HTTP
  }

  async close(): Promise<void> {
    await this.call('DELETE', '').finally(() => this.driver.kill());
    WebKitPage.drivers.delete(this.driver);
  }

  // Also those of tests that failed.
  static closeAll(): void {
    WebKitPage.drivers.forEach((one) => one.kill());
  }

  private async resize(size: { width: number; height: number }): Promise<void> {
    await this.call('POST', '/window/rect', size);
    const inside = await this.evaluate(() => ({ width: innerWidth, height: innerHeight }));
    await this.call('POST', '/window/rect', { width: 2 * size.width - inside.width, height: 2 * size.height - inside.height });
  }

  // The value of an expression, also where a promise brings it.
  private async run<R>(expression: string, given: unknown[]): Promise<R> {
    const script = `const given = [...arguments]; const done = given.pop(); new Promise((resolve) => resolve(${expression}))` +
      '.then((value) => done({ value }), (error) => done({ error: String(error) }));';
    const { value, error } = await this.call('POST', '/execute/async', { script, args: given }) as { value: R; error?: string };
    if (error !== undefined) {
      throw new Error(error);
    }
    return value;
  }

  private async type(all: string[]): Promise<void> {
    await this.keys(all.flatMap((value) => [{ type: 'keyDown', value }, { type: 'keyUp', value }]));
  }

  private async keys(actions: object[]): Promise<void> {
    await this.call('POST', '/actions', { actions: [{ type: 'key', id: 'keyboard', actions }] });
  }

  private async call(method: string, path: string, body?: object): Promise<unknown> {
    return call(method, this.address + path, body);
  }
}

async function session(driver: string, binary: string, patience: number): Promise<string> {
  const wanted = {
    'webkitgtk:browserOptions': {
      binary, args: ['--automation', '--enable-mock-capture-devices=true', '--enable-media-stream=true', '--autoplay-policy=allow'],
    },
  };
  for (const end = Date.now() + patience; ;) {
    try {
      const made = await call('POST', `${driver}/session`, { capabilities: { alwaysMatch: wanted } });
      return (made as { sessionId: string }).sessionId;
    } catch (error) {
      if (!(error instanceof TypeError) || Date.now() > end) {
        throw error; // it answers, or never will
      }
      await setTimeout(50);
    }
  }
}

async function call(method: string, url: string, body?: object): Promise<unknown> {
  const answer = await fetch(url, { method, ...(body && { body: JSON.stringify(body) }) });
  const { value } = await answer.json() as { value: { error?: string; message?: string } | null };
  if (!answer.ok) {
    throw new Error(`${value?.error}: ${value?.message}`);
  }
  return value;
}

function freePort(): Promise<number> {
  return new Promise((resolve, reject) => {
    const server = createServer().once('error', reject);
    server.listen(0, '127.0.0.1', () => {
      const { port } = server.address() as AddressInfo;
      server.close(() => resolve(port));
    });
  });
}

// The programs of Roomwise as processes, as somebody would start them in a terminal.
import assert from 'node:assert/strict';
import { spawn, type ChildProcessWithoutNullStreams } from 'node:child_process';
import { mkdirSync } from 'node:fs';
import { join } from 'node:path';

const kProgram = process.env['ROOMWISE_PROGRAM'] ?? '';
const kPatience = 120_000; // ms

export class Program {
  private output = '';
  private errors = '';
  private code: number | null = null;
  private readonly process: ChildProcessWithoutNullStreams;
  private listeners: (() => void)[] = [];

  // With a configuration of its own in `folder`, and with no network but the one that Roomwise brings.
  constructor(folder: string, private readonly words: readonly string[]) {
    const own = (name: string): string => {
      mkdirSync(join(folder, name), { recursive: true });
      return join(folder, name);
    };
    this.process = spawn(kProgram, words, {
      env: { ...process.env, ROOMWISE_MODELS: own('models'), XDG_DATA_HOME: own('data'), XDG_CONFIG_HOME: own('config') },
    });
    this.process.stdin.on('error', () => undefined); // it has ended
    this.process.stdout.on('data', (bytes: Buffer) => this.changed(() => (this.output += bytes.toString())));
    this.process.stderr.on('data', (bytes: Buffer) => this.changed(() => (this.errors += bytes.toString())));
    this.process.on('close', (code) => this.changed(() => (this.code = code ?? 128)));
    this.process.on('error', (error) => this.changed(() => {
      this.errors += `${kProgram || 'ROOMWISE_PROGRAM, which names the program'}: ${error.message}`;
      this.code ??= 127;
    }));
  }

  // Waits until it has written this to its standard output.
  async says(words: RegExp): Promise<RegExpExecArray> {
    await this.until(() => words.test(this.output) || this.code !== null, `says ${words}`);
    const found = words.exec(this.output);
    assert.ok(found, `'roomwise ${this.words.join(' ')}' ended without saying ${words}: ${this.output}${this.errors}`);
    return found;
  }

  press(key: string): void {
    this.process.stdin.write(key);
  }

  // Waits for its end, which must be a success.
  async succeeds(): Promise<void> {
    await this.until(() => this.code !== null, 'ends');
    assert.equal(this.code, 0, `'roomwise ${this.words.join(' ')}': ${this.output}${this.errors}`);
  }

  async kill(): Promise<void> {
    this.process.kill('SIGKILL');
    await this.until(() => this.code !== null, 'is killed');
  }

  private async until(holds: () => boolean, what: string): Promise<void> {
    await new Promise<void>((resolve, reject) => {
      const timer = setTimeout(() => {
        reject(new Error(`'roomwise ${this.words.join(' ')}' never ${what}: ${this.output}${this.errors}`));
      }, kPatience);
      const look = (): void => {
        if (holds()) {
          clearTimeout(timer);
          this.listeners = this.listeners.filter((one) => one !== look);
          resolve();
        }
      };
      this.listeners.push(look);
      look();
    });
  }

  private changed(change: () => void): void {
    change();
    [...this.listeners].forEach((look) => look());
  }
}

// `roomwise serve`, from its first words on.
export class HomeServer {
  private constructor(private readonly program: Program, readonly port: number, readonly url: string) {}

  static async start(folder: string, home: string, pages: string, port = 0): Promise<HomeServer> {
    const program = new Program(folder, ['serve', home, '--port', String(port), '--pages', pages]);
    const [, url = '', own = ''] = await program.says(/(https:\/\/127\.0\.0\.1:(\d+)) serves[^]*Ctrl-C stops it/);
    return new HomeServer(program, Number(own), url);
  }

  // The six digits that it shows for the first helper.
  async helperCode(): Promise<string> {
    const [, first = '', last = ''] = await this.program.says(/To pair a helper: code (\d{3}) (\d{3})/);
    return first + last;
  }

  async kill(): Promise<void> {
    await this.program.kill();
  }
}

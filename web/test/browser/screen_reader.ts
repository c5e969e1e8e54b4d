// A page as who cannot see has it: live regions, roles, names and keys, out of the accessibility tree alone. Chromium's.
import assert from 'node:assert/strict';
import type { CDPSession, SerializedAXNode } from 'puppeteer-core';

import { kPatience, type Visit } from './harness';

// Reads what is new in live regions, a text of the tree each, as a screen reader does.
export class ScreenReader {
  readonly heard: string[] = [];
  private readonly known = new Set<number>();

  private constructor(private readonly visit: Visit, private readonly tree: CDPSession) {}

  static async of(visit: Visit): Promise<ScreenReader> {
    const tree = await visit.page.createCDPSession();
    await tree.send('Accessibility.enable');
    return new ScreenReader(visit, tree);
  }

  async listen(): Promise<void> {
    const { nodes } = await this.tree.send('Accessibility.getFullAXTree');
    const byId = new Map(nodes.map((node) => [node.nodeId, node]));
    const isLive = (id: string | undefined): boolean => {
      const node = byId.get(id ?? '');
      const live = node?.properties?.find((one) => one.name === 'live')?.value.value as unknown;
      return node !== undefined && (live === 'polite' || live === 'assertive' || isLive(node.parentId));
    };
    for (const { nodeId, ignored, role, name, backendDOMNodeId: element } of nodes) {
      if (!ignored && role?.value === 'StaticText' && element !== undefined && !this.known.has(element) && isLive(nodeId)) {
        this.known.add(element);
        this.heard.push(String(name?.value));
      }
    }
  }

  // Waits until this is the newest.
  async hears(words: string): Promise<void> {
    const given = Date.now() + kPatience;
    do {
      await this.listen();
    } while (this.heard.at(-1) !== words && Date.now() < given);
    assert.equal(this.heard.at(-1), words, JSON.stringify(this.heard));
  }

  // Waits for words like these behind the first `known` of what was heard, and gives them.
  async hearsLike(words: RegExp, known: number): Promise<string> {
    const given = Date.now() + kPatience;
    const find = (): string | undefined => this.heard.slice(known).find((one) => words.test(one));
    do {
      await this.listen();
    } while (find() === undefined && Date.now() < given);
    return find() ?? assert.fail(`nothing like ${words} was heard; only: ${JSON.stringify(this.heard.slice(known))}`);
  }

  async names(role: string): Promise<string[]> {
    const found: string[] = [];
    const walk = (node: SerializedAXNode): void => {
      if (node.role === role) {
        found.push(node.name ?? '');
      }
      node.children?.forEach(walk);
    };
    walk(await this.snapshot());
    return found;
  }

  async focused(): Promise<string> {
    const find = (node: SerializedAXNode): string | null =>
      node.focused === true && node.role !== 'RootWebArea' ? (node.name ?? '') : (node.children ?? []).map(find).find((name) => name !== null) ?? null;
    return find(await this.snapshot()) ?? '';
  }

  // By Tab alone.
  async press(name: string): Promise<void> {
    const passed: string[] = [];
    for (let i = 0; i < 60; i += 1) {
      const here = await this.focused();
      if (here === name) {
        await this.visit.page.keyboard.press('Enter');
        return;
      }
      passed.push(here);
      await this.visit.page.keyboard.press('Tab');
    }
    assert.fail(`Tab does not lead to '${name}'; it leads to ${JSON.stringify(passed)}`);
  }

  private async snapshot(): Promise<SerializedAXNode> {
    const tree = await this.visit.page.accessibility.snapshot();
    assert.ok(tree);
    return tree;
  }
}

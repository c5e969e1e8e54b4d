import assert from 'node:assert/strict';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';

import type { Repository } from './links';
import { readPage } from './markdown';
import { buildManual, checkChapters, checkLinks } from './site';

const repository: Repository = {
  isPage: (file) => file.endsWith('.md'),
  exists: (path) => path === 'docs/pictures/map.png' || path === 'roomwise/a.h',
};
const page = (file: string, markdown: string) => readPage(file, markdown, repository);

test('a page has its title, anchors, and links that work beside it', () => {
  const read = page('docs/manual/a.md', '# How to\n\n## How\n\n## How\n\nSee [rooms](../rooms.md#idea) and [code](../../roomwise/a.h).\n');
  assert.equal(read.title, 'How to');
  assert.deepEqual(read.anchors, ['how-to', 'how', 'how-1']);
  assert.match(read.html, /<a href="\.\.\/rooms\.html#idea">rooms<\/a>/);
  assert.match(read.html, /<span class="source" title="in the sources: roomwise\/a\.h">code<\/span>/);
});

test('tables and code scroll by themselves, and can be reached by keyboard', () => {
  const read = page('docs/a.md', '# A\n\n| a | b |\n| --- | --- |\n| 1 | 2 |\n\n    x < y\n');
  assert.match(read.html, /<div class="wide" role="region" tabindex="0" aria-label="Table 1"><table>/);
  assert.match(read.html, /<pre tabindex="0"><code>x &lt; y\n<\/code><\/pre>/);
});

test('markup in the text stays text', () => {
  assert.doesNotMatch(page('docs/a.md', '# A\n\n<script>alert(1)</script>\n').html, /<script>/);
});

test('what is read aloud has the words and none of the signs', () => {
  assert.equal(page('docs/a.md', '# Ask\n\n- **Where am I**: the\n  room.\n').plain, 'Ask.\n\nWhere am I: the room.');
});

test('a page without a heading and a picture without words are refused', () => {
  assert.throws(() => page('docs/a.md', 'text\n'), /no heading/);
  assert.throws(() => page('docs/a.md', '# A\n\n![](pictures/map.png)\n'), /no words/);
});

test('an anchor that is not there is refused', () => {
  const pages = [page('docs/a.md', '# A\n\n[b](b.md#here)\n'), page('docs/b.md', '# B\n\n## There\n')];
  assert.throws(() => checkLinks(pages), /docs\/a\.md: a link leads to b\.md#here, but docs\/b\.md has no heading 'here'/);
});

test('every chapter is there, and every page can be reached', () => {
  const pages = [page('docs/a.md', '# A\n\n[b](b.md)\n'), page('docs/b.md', '# B\n'), page('docs/c.md', '# C\n')];
  const chapter = (file: string) => ({ file, about: '' });
  assert.throws(() => checkChapters([chapter('d.md')], pages), /there is no docs\/d\.md/);
  assert.throws(() => checkChapters([chapter('a.md')], pages), /leads to docs\/c\.md/);
  checkChapters([chapter('a.md'), chapter('c.md')], pages);
});

test('pages of the headers are part of the manual where they were made', () => {
  const root = mkdtempSync(join(tmpdir(), 'roomwise-manual-'));
  mkdirSync(join(root, 'docs/manual'), { recursive: true });
  mkdirSync(join(root, 'headers'));
  writeFileSync(join(root, 'docs/manual/contents.json'), JSON.stringify({
    title: 'The manual',
    groups: [{ title: 'For helpers', chapters: [] }, { title: 'For engineers', reference: true, chapters: [{ file: 'manual/a.md', about: 'All.' }] }],
  }));
  writeFileSync(join(root, 'docs/manual/a.md'), '# A\n');
  writeFileSync(join(root, 'headers/index.html'), 'made by doxygen');
  const pageOf = (out: string, file: string) => readFileSync(join(root, out, file), 'utf8');
  try {
    buildManual(root, join(root, 'without'));
    assert.doesNotMatch(pageOf('without', 'index.html') + pageOf('without', 'manual/a.html'), /reference/);
    assert.ok(!existsSync(join(root, 'without/reference')));
    buildManual(root, join(root, 'with'), join(root, 'headers'));
    assert.equal(pageOf('with', 'index.html').match(/<a href="reference\/index\.html">/g)?.length, 1);
    assert.match(pageOf('with', 'manual/a.html'), /<a href="\.\.\/reference\/index\.html">/);
    assert.equal(pageOf('with', 'reference/index.html'), 'made by doxygen');
  } finally {
    rmSync(root, { recursive: true });
  }
});

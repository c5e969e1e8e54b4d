import assert from 'node:assert/strict';
import { test } from 'node:test';

import { addressOf, anchorOf, relativeAddress, targetOf, type Repository } from './links';

const repository: Repository = {
  isPage: (file) => ['docs/rooms.md', 'docs/manual/helper.md'].includes(file),
  exists: (path) => ['roomwise/rooms/learner.h', 'docs/pictures/map.png', 'README.md'].includes(path),
};

test('links lead to pages, pictures, sources and elsewhere', () => {
  assert.deepEqual(targetOf('../rooms.md#the-idea', 'docs/manual/helper.md', repository), { kind: 'page', file: 'docs/rooms.md', anchor: 'the-idea' });
  assert.deepEqual(targetOf('#words', 'docs/rooms.md', repository), { kind: 'page', file: 'docs/rooms.md', anchor: 'words' });
  assert.deepEqual(targetOf('pictures/map.png', 'docs/rooms.md', repository), { kind: 'picture', file: 'docs/pictures/map.png' });
  assert.deepEqual(targetOf('../roomwise/rooms/learner.h', 'docs/rooms.md', repository), { kind: 'source', path: 'roomwise/rooms/learner.h' });
  assert.deepEqual(targetOf('https://example.org/a', 'docs/rooms.md', repository), { kind: 'outside', href: 'https://example.org/a' });
});

test('a link to what is not there, or out of the repository, is refused by name', () => {
  assert.throws(() => targetOf('../rooms/learnt.h', 'docs/rooms.md', repository), /docs\/rooms\.md: a link leads to \.\.\/rooms\/learnt\.h/);
  assert.throws(() => targetOf('../../secret', 'docs/rooms.md', repository), /not there/);
});

test('a page lies where docs has it, and links are relative', () => {
  assert.equal(addressOf('docs/manual/helper.md'), 'manual/helper.html');
  assert.equal(relativeAddress('docs/manual/helper.md', 'rooms.html'), '../rooms.html');
  assert.equal(relativeAddress('docs/rooms.md', 'manual/helper.html'), 'manual/helper.html');
  assert.equal(relativeAddress('docs/manual/helper.md', '../css/manual.css'), '../../css/manual.css');
});

test('anchors are those of GitHub', () => {
  assert.equal(anchorOf("The browser's warning"), 'the-browsers-warning');
  assert.equal(anchorOf('Größe, F und "x_y"'), 'größe-f-und-x_y');
});

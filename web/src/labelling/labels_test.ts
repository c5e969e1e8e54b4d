import assert from 'node:assert/strict';
import { test } from 'node:test';

import {
  bordersOf, boxBetween, moved, noLabels, parseLabels, textOf, viewOf, whatIsMissing, withBox, withChange, withNewThing,
  withoutBox, withoutThing, withSide, type Labels, type LabelledRecording, type Picture,
} from './labels';

const picture: Picture = { frame: 12, file: 'pictures/12.jpg', width: 640, height: 480 };
const recording: LabelledRecording = { name: 'office', pictures: [picture], words: ['chair'] };

function twoThings(): Labels {
  const labels = withNewThing(withNewThing(noLabels('office', 'A'), 'chair'), 'table');
  return withBox(withBox(labels, 1, picture, [10.4, 20, 100, 200]), 2, picture, [-3, 5, 300, 481]);
}

test('a thing has one box in a picture, in whole px within it, cut by the borders that it touches', () => {
  const labels = twoThings();
  const [chair, table] = labels.things;
  assert.deepEqual(chair && viewOf(chair, 12), { frame: 12, box: [10, 20, 100, 200], cut: [], occluded: false });
  assert.deepEqual(table && viewOf(table, 12), { frame: 12, box: [0, 5, 300, 480], cut: ['left', 'bottom'], occluded: false });
  const again = withBox(labels, 1, picture, [50, 60, 70, 80]);
  assert.deepEqual(again.things[0]?.views.map((view) => view.box), [[50, 60, 70, 80]]);
  assert.deepEqual(labels.things[0]?.views[0]?.box, [10, 20, 100, 200], 'what was before stays as it was');
});

test('views are kept by picture, and what is taken away leaves the rest', () => {
  const later = { ...picture, frame: 3 };
  const labels = withBox(twoThings(), 1, later, [1, 2, 30, 40]);
  assert.deepEqual(labels.things[0]?.views.map((view) => view.frame), [3, 12]);
  assert.deepEqual(withoutBox(labels, 1, 12).things[0]?.views.map((view) => view.frame), [3]);
  const left = withoutThing(labels, 1);
  assert.deepEqual(left.things.map((thing) => thing.name), ['table']);
  assert.equal(withNewThing(left, 'cup').things[1]?.id, 3, 'no number is given twice');
});

test('a box is moved and resized within its picture, and never turns over', () => {
  assert.deepEqual(moved([600, 400, 630, 470], 50, 50, picture), [610, 410, 640, 480]);
  assert.deepEqual(withSide([10, 10, 20, 20], 'left', 50, picture), [19, 10, 20, 20]);
  assert.deepEqual(withSide([10, 10, 20, 20], 'bottom', 1000, picture), [10, 10, 20, 480]);
  assert.deepEqual(boxBetween(30, 40, 10, 20), [10, 20, 30, 40]);
  assert.equal(boxBetween(30, 40, 31, 90), null, 'a slip of the mouse is no box');
  assert.deepEqual(bordersOf([0, 0, 640, 480], picture), ['left', 'top', 'right', 'bottom']);
});

test('what was saved is read again as it was', () => {
  const labels = withChange(twoThings(), 2, { sure: false, side: ['top', 'front'], note: 'by the "window"', transient: true });
  assert.deepEqual(parseLabels(textOf(labels), recording), labels);
  assert.deepEqual(parseLabels(textOf(noLabels('office', 'B')), recording).things, []);
});

test('a file that is none, or of another recording, is refused in words', () => {
  assert.throws(() => parseLabels('{"things"', recording), /no JSON/);
  assert.throws(() => parseLabels('[]', recording), /no reader and things/);
  assert.throws(() => parseLabels(textOf(noLabels('flat', 'A')), recording), /belongs to the recording flat, not to office/);
  const broken = textOf(twoThings()).replace('[10,20,100,200]', '[10,20,100]');
  assert.throws(() => parseLabels(broken, recording), /Thing 1 of this file has a view without frame or box/);
});

test('a reader is told what is missing', () => {
  const labels = withNewThing(withChange(twoThings(), 1, { name: ' ' }), 'cup');
  assert.deepEqual(whatIsMissing(labels), ['Thing 1 has no name.', 'Thing 3 (cup) has no box.']);
  assert.deepEqual(whatIsMissing(twoThings()), []);
});

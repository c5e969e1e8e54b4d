import assert from 'node:assert/strict';
import { test } from 'node:test';

import { makeCoverage, makeHome, makePlan } from '../../test/made_up_home';
import { lightAt, placeWords, tellCoverage } from './coverage';

const at = (hour: number): number => new Date(2026, 4, 3, hour, 30).getTime() / 1000;

test('what is missing is told by room, in sentences, with what to do', () => {
  const { groups } = tellCoverage(makeCoverage(at(12)), makeHome(), makePlan());
  assert.deepEqual(groups.map(({ mark, heading }) => `${mark} ${heading}`), [' The whole home', '1 bathroom', '2 bedroom', '3 kitchen']);
  assert.equal(groups[0]?.sentences[0]?.say, '6 pictures of the walk walk belong to no room.');
  assert.equal(groups[1]?.sentences[0]?.todo, 'Walk through it and turn once round in its middle; 30 are enough.');
  assert.match(groups[3]?.sentences[0]?.say ?? '', /^It was seen by day only: on the walk walk, May 3, 2026/);
  assert.equal(groups[3]?.sentences[0]?.todo, 'Walk through it after dark, with the lamps on.');
});

test('places on the plan have the numbers of the list', () => {
  const { groups, marks } = tellCoverage(makeCoverage(at(12)), makeHome(), makePlan());
  assert.deepEqual(marks.map(({ mark }) => mark), ['1', '2', '2a', '3', '3a']);
  const gap = groups[2]?.sentences[1];
  assert.equal(gap?.mark, '2a');
  assert.equal(gap?.say, 'A part of the floor was seen from afar only: at its upper right corner on the plan, over 1.2 m.');
  assert.equal(groups[3]?.sentences[1]?.say, 'The floor goes on where no walk saw it: by the refrigerator, over 0.9 m.');
});

test('a room that is not on the plan has no number there', () => {
  const { groups, marks } = tellCoverage(makeCoverage(at(12)), makeHome(), { rooms: [], doors: [] });
  assert.deepEqual(marks.map(({ mark }) => mark), ['2a', '3a']);
  assert.deepEqual(groups.map(({ mark }) => mark), ['', '', '2', '3']);
});

test('a place is told by the door that is near', () => {
  assert.equal(placeWords({ beside: null, place: [1.5, 2] }, 'kitchen', makePlan()), 'by the door to corridor');
  assert.equal(placeWords({ beside: null, place: [0.2, 3.1] }, 'kitchen', makePlan()), 'at its left side on the plan');
  const open = makePlan();
  open.doors.forEach((one) => (one.door = false));
  assert.equal(placeWords({ beside: null, place: [1.5, 2] }, 'kitchen', open), 'at its lower side on the plan', 'nobody finds an open border');
});

test('only hours that are light, or dark, all over the year tell the light', () => {
  assert.deepEqual([at(12), at(0), at(18)].map(lightAt), ['day', 'night', null]);
  const dusk = tellCoverage(makeCoverage(at(18)), makeHome(), makePlan()).groups[3]?.sentences[0];
  assert.equal(dusk?.say, 'Only the walk walk saw it.');
  assert.match(dusk?.todo ?? '', /by the other light/);
});

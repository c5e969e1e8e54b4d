import assert from 'node:assert/strict';
import { test } from 'node:test';
import { roomCalled } from '../shared/spoken';
import { setLanguage } from '../shared/texts';
import { goalCalled, goalsOf } from './goals';

test('a room that is called as the way out is can be chosen beside it', () => {
  setLanguage('en');
  const goals = goalsOf({ spots: ['my chair'], rooms: ['Exit', 'kitchen'], things: ['fridge'] }, 'Exit');
  assert.deepEqual(goals.map((goal) => goal.label), ['my chair', 'Exit', 'Exit, the room', 'kitchen', 'fridge']);
  assert.equal(goalCalled(goals, 'Exit').kind, 'way out');
  assert.deepEqual(goalCalled(goals, 'Exit, the room'), { kind: 'room', name: 'Exit', label: 'Exit, the room' });
  assert.equal(goalCalled(goals, 'kitchen').kind, 'room');
  assert.equal(goalCalled(goals, 'my chair').kind, 'spot');
});

test('a thing that is called as a room is can be chosen beside it', () => {
  setLanguage('de');
  const goals = goalsOf({ spots: [], rooms: ['Bar'], things: ['Bar', 'Bar'] }, 'Ausgang');
  assert.deepEqual(goals.map((goal) => goal.label), ['Ausgang', 'Bar', 'Bar (Gegenstand)']);
  assert.deepEqual(goals.map((goal) => goal.kind), ['way out', 'room', 'thing']);
});

test('what is called as the way out, or as a spot, is that, once', () => {
  setLanguage('en');
  const goals = goalsOf({ spots: ['Exit', 'my chair'], rooms: [], things: ['Exit', 'my chair'] }, 'Exit');
  assert.deepEqual(goals.map((goal) => [goal.kind, goal.label]), [['spot', 'my chair'], ['way out', 'Exit']]);
});

test('of things of one name in different rooms each room has its own', () => {
  const thingsInRooms = [{ thing: 'chair', rooms: ['hall', 'kitchen'] }];
  const goals = goalsOf({ spots: [], rooms: [], things: ['bed', 'chair'], thingsInRooms }, 'Exit');
  assert.deepEqual(goals.map((goal) => goal.label), ['Exit', 'bed', 'chair, hall', 'chair, kitchen']);
  assert.deepEqual(goalCalled(goals, 'chair, kitchen'), { kind: 'thing', name: 'chair', room: 'kitchen', label: 'chair, kitchen' });
});

test('what is typed and not in the list is asked for as a thing', () => {
  assert.deepEqual(goalCalled([], 'teapot'), { kind: 'thing', name: 'teapot', label: 'teapot' });
});

test('rooms are listed as each language calls them, and a name that two would have is left to neither', () => {
  const called = (room: string): string => roomCalled('de', room);
  const thingsInRooms = [{ thing: 'Stuhl', rooms: ['kitchen', "Anna's"] }];
  const goals = goalsOf({ spots: [], rooms: ['kitchen', "Anna's", 'dining', 'dining room'], things: ['Stuhl'], thingsInRooms }, 'Ausgang', called);
  assert.deepEqual(goals.map((goal) => goal.label),
    ['Ausgang', 'Küche', "Anna's", 'dining', 'dining room', 'Stuhl, Küche', "Stuhl, Anna's"]);
  assert.deepEqual(goalCalled(goals, 'Küche'), { kind: 'room', name: 'kitchen', label: 'Küche' });
});

import assert from 'node:assert/strict';
import test from 'node:test';
import type { Question } from '../shared/protocol';
import { kPlacedMs, LedAgain } from './led_again';

const kBed: Question = { question: 'take_me_to', thing: 'bed' };
const kPause: Question = { question: 'guide', wish: 'pause' };
const kResume: Question = { question: 'guide', wish: 'resume' };
const kEnd: Question = { question: 'guide', wish: 'end' };

function ledToTheBed(): LedAgain {
  const led = new LedAgain();
  led.ask(1, kBed);
  led.heard({ key: 'guide', message: 'guide.begin', answer_to: 1 });
  return led;
}

test('who is led is led on once the computer sees the place again, and once', () => {
  const led = ledToTheBed();
  assert.equal(led.lost(), true);
  assert.equal(led.seen(true, 0), null, 'the map is not ready');
  led.sees(true, 1000);
  assert.equal(led.seen(false, 1500), null);
  assert.deepEqual(led.seen(true, 1600), kBed);
  assert.equal(led.seen(true, 1700), null);
});

test('without a place it is asked for all the same after a while', () => {
  const led = ledToTheBed();
  led.lost();
  led.sees(true, 1000);
  assert.deepEqual(led.seen(false, 1001 + kPlacedMs), kBed);
});

test('a question in words that the guide answers leads, another does not', () => {
  const words: Question = { question: 'in_words', text: 'bring me to bed' };
  const led = new LedAgain();
  led.ask(1, words);
  led.heard({ key: 'where', message: 'where.direction', answer_to: 1 });
  assert.equal(led.lost(), false);
  led.ask(2, words);
  led.heard({ key: 'guide', message: 'guide.begin', answer_to: 2 });
  assert.equal(led.lost(), true);
});

test('who has arrived, or ended it, is not led on', () => {
  const arrived = ledToTheBed();
  arrived.heard({ key: 'guide', message: 'guide.there_ahead', answer_to: null });
  assert.equal(arrived.lost(), false);
  const ended = ledToTheBed();
  ended.lost();
  ended.wish(kEnd);
  ended.sees(true, 0);
  assert.equal(ended.seen(true, 10), null);
});

test('who paused is led on when they go on', () => {
  const led = ledToTheBed();
  led.wish(kPause);
  led.lost();
  led.sees(true, 0);
  assert.equal(led.seen(true, 10), null);
  assert.deepEqual(led.wish(kResume), kBed);
});

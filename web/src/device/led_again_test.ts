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

test('a computer that has forgotten them is asked anew, whatever they asked before it saw the place', () => {
  const led = ledToTheBed();
  led.lost();
  led.wish({ question: 'guide', wish: 'next' });
  led.heard({ key: 'guide', message: 'guide.not_running', answer_to: 2 });
  led.sees(true, 0);
  assert.deepEqual(led.seen(true, 10), kBed);
});

test('who asked for another goal meanwhile is not led to the old one', () => {
  const kLamp: Question = { question: 'take_me_to', thing: 'lamp' };
  const led = ledToTheBed();
  led.lost();
  led.sees(true, 0);
  led.ask(2, kLamp);
  assert.equal(led.seen(true, 10), null);
  assert.equal(led.lost(), true);
  led.sees(true, 20);
  assert.deepEqual(led.seen(true, 30), kLamp);
});

test('words that wait for their answer come first', () => {
  const led = ledToTheBed();
  led.lost();
  led.sees(true, 0);
  led.ask(2, { question: 'in_words', text: 'where is the lamp' });
  assert.equal(led.seen(true, 10), null);
  led.heard({ key: 'where', message: 'where.unknown', answer_to: 2 });
  assert.deepEqual(led.seen(true, 20), kBed, 'a thing that nobody knows does not end the way to the bed');
  const refused = ledToTheBed();
  refused.lost();
  refused.sees(true, 0);
  refused.ask(2, { question: 'in_words', text: 'blorb' });
  refused.refused(2);
  assert.deepEqual(refused.seen(true, 20), kBed);
});

test('how far, asked in words, is no goal', () => {
  const led = ledToTheBed();
  led.ask(2, { question: 'in_words', text: 'how far' });
  led.heard({ key: 'guide', message: 'guide.far', answer_to: 2 });
  led.lost();
  led.sees(true, 0);
  assert.deepEqual(led.seen(true, 10), kBed);
});

test('a goal that is not known leads nowhere', () => {
  const led = new LedAgain();
  led.ask(1, kBed);
  assert.equal(led.isLed, true);
  led.heard({ key: 'where', message: 'where.unknown', answer_to: 1 });
  assert.equal(led.isLed, false);
});

test('who asks for what is not known is led on as before', () => {
  const kPiano: Question = { question: 'take_me_to', thing: 'piano' };
  const led = ledToTheBed();
  led.ask(2, kPiano);
  led.ask(3, kPiano);
  led.heard({ key: 'where', message: 'where.unknown', answer_to: 3 });
  assert.equal(led.isLed, true);
  led.wish(kPause);
  led.ask(4, kPiano);
  led.refused(4);
  led.lost();
  led.sees(true, 0);
  assert.equal(led.seen(true, 10), null, 'they paused');
  assert.deepEqual(led.wish(kResume), kBed);
  led.ask(5, kBed);
  led.heard({ key: 'where', message: 'where.unknown', answer_to: 5 });
  assert.equal(led.isLed, false, 'the computer that came back does not know it');
});

test('who waits to hear whether a goal is known is led on as before where it is not', () => {
  const led = ledToTheBed();
  const piano: Question = { question: 'take_me_to', thing: 'piano' };
  led.ask(2, piano);
  led.lost();
  led.sees(true, 0);
  assert.deepEqual(led.seen(true, 10), piano);
  led.ask(3, piano);
  led.heard({ key: 'where', message: 'where.unknown', answer_to: 3 });
  assert.deepEqual(led.seen(true, 20), kBed);
});

test('who ended it while the connection was lost is led to nothing of before', () => {
  const led = ledToTheBed();
  led.ask(2, { question: 'take_me_to', thing: 'piano' });
  led.lost();
  led.wish(kEnd);
  led.sees(true, 0);
  led.ask(3, { question: 'take_me_to', thing: 'sofa' });
  led.heard({ key: 'where', message: 'where.unknown', answer_to: 3 });
  assert.equal(led.seen(true, 10), null);
});

test('a pause ends with the way', () => {
  const led = ledToTheBed();
  led.wish(kPause);
  led.wish(kEnd);
  const words: Question = { question: 'in_words', text: 'bring me to bed' };
  led.ask(2, words);
  led.heard({ key: 'guide', message: 'guide.begin', answer_to: 2 });
  led.lost();
  led.sees(true, 0);
  assert.deepEqual(led.seen(true, 10), words);
});

// Somebody is led by what a screen reader gets and by keys: nothing is looked for but in the accessibility tree.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import type { Prompt } from '../../src/shared/protocol';
import { makePrompt, type StandInServer } from '../stand_in_server';
import { closeBrowser, kPhone, onlyInChromium, openVisit, until, withServer, type Visit } from './harness';
import { ScreenReader } from './screen_reader';

after(closeBrowser);
const options = { skip: onlyInChromium('the accessibility tree is not told') };

// A computer that leads, message by message.
class Leader {
  private answered = 0;

  constructor(private readonly server: StandInServer) {
    server.answersQuestions = false;
  }

  tell(message: string, text: string, more: Partial<Prompt> = {}): void {
    this.server.tell('device', makePrompt({ key: 'guide', message, text, sound: 'none', ...more }));
  }

  // The next question that the page asks; how it is answered.
  async answer(question: object, message: string, text: string): Promise<void> {
    const { asked } = this.server.newest('device');
    await until(() => asked.length > this.answered);
    const { id, t, type, ...said } = asked[this.answered] as Record<string, unknown>;
    assert.deepEqual(said, question, `${String(type)} at ${String(t)}`);
    this.answered += 1;
    this.tell(message, text, { answer_to: Number(id) });
  }

  // Until the page has sent so many pictures, four a second: longer than anything is said here.
  async seesPictures(more: number): Promise<void> {
    const { frames } = this.server.newest('device');
    await until(() => this.server.newest('device').frames >= frames + more);
  }
}

async function begin(server: StandInServer): Promise<{ visit: Visit; reader: ScreenReader; leader: Leader }> {
  const visit = await openVisit(server, { role: 'device', size: kPhone });
  const reader = await ScreenReader.of(visit);
  await visit.go('/device');
  await visit.sees('Who shall speak?');
  while (!(await reader.focused()).startsWith("The phone's own voice")) {
    await visit.page.keyboard.press('Tab');
  }
  await visit.page.keyboard.press('ArrowDown');
  await reader.press('Start');
  await visit.sees('Camera sees', '.chip');
  const leader = new Leader(server);
  await reader.press('Take me…');
  await reader.press('microwave');
  await leader.answer({ question: 'take_me_to', thing: 'microwave' }, 'guide.begin', 'To the microwave: about 6 metres.');
  await reader.hears('To the microwave: about 6 metres.');
  assert.equal(await reader.focused(), 'Take me…', 'focus comes back from the list');
  return { visit, reader, leader };
}

test('somebody is led to a thing: all is heard once, in its order, and nothing that a new plan made untrue', options, () => withServer(async (server) => {
  const { visit, reader, leader } = await begin(server);
  leader.tell('guide.place_right', 'The door is on your right.');
  await reader.hears('The door is on your right.');
  leader.tell('guide.turn_right', 'Turn right.');
  await reader.hears('Turn right.');
  leader.tell('guide.walk_to', 'Straight on, 4 metres to the door.');
  await reader.hears('Straight on, 4 metres to the door.');
  // While that is being said: what comes next, then that they are off the way. Neither may be heard after it.
  leader.tell('guide.soon_left', 'In 2 metres: turn left.');
  leader.tell('guide.off', 'Off the way. Stop.', { priority: 'hazard', sound: 'alert' });
  await reader.hears('Off the way. Stop.');
  await leader.seesPictures(10);
  leader.tell('guide.turn_around', 'Turn around.');
  await reader.hears('Turn around.');
  leader.tell('guide.walk_to', 'Straight on, 3 metres to the microwave.');
  await reader.hears('Straight on, 3 metres to the microwave.');

  await reader.press('Pause');
  await leader.answer({ question: 'guide', wish: 'pause' }, 'guide.paused', 'Paused.');
  await reader.hears('Paused.');
  await reader.press('Go on');
  await leader.answer({ question: 'guide', wish: 'resume' }, 'guide.resumed', 'Going on.');
  await reader.hears('Going on.');
  await reader.press('Repeat');
  await leader.answer({ question: 'repeat' }, 'guide.walk_to', 'Straight on, 2 metres to the microwave.');
  await reader.hears('Straight on, 2 metres to the microwave.');

  assert.ok((await reader.names('button')).includes('End'));
  leader.tell('guide.there_ahead', 'You are there: the microwave ahead, in reach.', { sound: 'back' });
  await reader.hears('You are there: the microwave ahead, in reach.');
  await leader.seesPictures(20);
  await reader.listen();
  assert.deepEqual(reader.heard, [
    'To the microwave: about 6 metres.', 'The door is on your right.', 'Turn right.', 'Straight on, 4 metres to the door.',
    'Off the way. Stop.', 'Turn around.', 'Straight on, 3 metres to the microwave.', 'Paused.', 'Going on.',
    'Straight on, 2 metres to the microwave.', 'You are there: the microwave ahead, in reach.',
  ]);
  assert.ok(!(await reader.names('button')).includes('End'), 'nobody is led any more');
  await visit.close();
}));

test('somebody ends being led, and hears nothing more of it', options, () => withServer(async (server) => {
  const { visit, reader, leader } = await begin(server);
  leader.tell('guide.walk_to', `Straight on, 4 metres to the door${', which is open'.repeat(20)}.`);
  await reader.hears(`Straight on, 4 metres to the door${', which is open'.repeat(20)}.`);
  leader.tell('guide.soon_left', 'In 2 metres: turn left.');
  await reader.press('End');
  await leader.answer({ question: 'guide', wish: 'end' }, 'guide.ended', 'Guidance has ended.');
  await reader.hears('Guidance has ended.');
  await leader.seesPictures(12);
  await reader.listen();
  assert.equal(reader.heard.at(-1), 'Guidance has ended.');
  assert.ok(!reader.heard.includes('In 2 metres: turn left.'));
  assert.equal(await reader.focused(), 'Take me…');
  await visit.close();
}));

// Recording a walk with this phone alone: augmented reality where the browser has it, else words on which app to use.
import { request, spokenFailure } from '../shared/api';
import { at } from '../shared/base';
import { openDialog } from '../shared/dialog';
import { h } from '../shared/dom';
import { wordsOfEnd } from '../shared/job_words';
import type { Job, Role } from '../shared/protocol';
import { counted, text, type TextKey } from '../shared/texts';
import { ArCamera, canRecord, failureOf, type Taken } from './ar/ar_camera';
import { WalkCoach } from './ar/walk_coach';
import type { Camera } from '../shared/camera';
import { ownNotice } from './own_prompt';
import type { Phone } from './phone';
import type { PromptPlayer } from './prompt_player';

export class WalkRecording {
  private ar: ArCamera | null = null;
  private coach = new WalkCoach();
  private isBeginning = false;
  private isEnding = false; // it was asked for
  private waitsForMap = false;
  private isRecorded = false; // the computer waits for this phone's pictures
  private readonly mayRecord: Promise<boolean> = canRecord(); // asked early: a tap does not last long

  constructor(
    private readonly phone: Phone, private readonly camera: Camera, private readonly player: PromptPlayer,
    private readonly role: () => Role,
  ) {
    phone.whenRecording = (state) => {
      const isMissed = state === 'none' && this.isRecorded; // it ended while the phone was away
      this.isRecorded = state === 'recording' || state === 'failed'; // a picture that could not be stored ends nothing
      if (state === 'saved' || state === 'empty' || isMissed) { // by a helper, perhaps
        this.phone.setWaits(false);
        void this.endSession();
      }
      if (isMissed) {
        this.say(text('ar.over'), 'alert', 'answer');
      }
    };
    phone.whenJob = (job) => this.hearJob(job);
  }

  // Within a tap.
  async begin(): Promise<void> {
    if (this.ar || this.isBeginning) {
      return;
    }
    this.isBeginning = true;
    this.player.withdrawAnswers();
    try {
      if (await this.mayRecord) {
        await this.beginSession();
      } else {
        openAdvice(this.role());
      }
    } finally {
      this.isBeginning = false;
    }
  }

  private async beginSession(): Promise<void> {
    this.camera.hold();
    this.phone.setWaits(false);
    let isGone = false;
    try {
      this.coach = new WalkCoach();
      this.ar = await ArCamera.open({
        taken: (what) => this.see(what),
        ended: () => {
          isGone = true;
          void this.ended();
        },
      });
    } catch (error) {
      void this.camera.letGo();
      const why = failureOf(error);
      this.say(text(`ar.${why}`), 'alert', 'answer');
      if (why === 'unsupported') {
        openAdvice(this.role());
      }
      return;
    }
    this.say(text('ar.begun'), 'none', 'answer');
    await this.phone.use(this.ar, true);
    if (!isGone) {
      await this.beginRecording();
    }
  }

  // One that was broken off is gone on with.
  private async beginRecording(): Promise<void> {
    if (this.isRecorded) {
      return;
    }
    const device = this.phone.number;
    if (this.role() !== 'helper' || device === null) {
      this.say(text('ar.ready'), 'none', 'answer');
      return;
    }
    try {
      await request('POST', '/api/recording', { device, name: nameOfWalk(new Date()) });
    } catch (error) {
      await this.endSession();
      this.say(`${text('ar.not_begun')} ${spokenFailure(error)}`, 'alert', 'answer');
    }
  }

  // Ends the recording; who may not leaves that to the helper.
  async stop(): Promise<void> {
    this.player.withdrawAnswers();
    if (this.role() === 'helper' && this.isRecorded) {
      try {
        this.waitsForMap = true;
        await request('POST', '/api/recording/stop');
      } catch (error) {
        this.waitsForMap = false;
        this.phone.setWaits(true); // it may go on, and can be ended still
        this.say(spokenFailure(error), 'alert', 'answer');
      }
    }
    await this.endSession();
  }

  tellState(): void {
    this.player.withdrawAnswers();
    const words = this.isRecorded ? counted('ar.pictures', this.phone.state.pictures) : text('ar.ready');
    this.say(words, 'none', 'answer');
  }

  private see(taken: Taken): void {
    this.phone.pictureCame();
    const news = this.coach.see(taken, this.isRecorded ? this.phone.state.pictures : 0);
    const words = [
      news.pictures === null ? '' : counted('ar.pictures', news.pictures),
      news.advice ? text(`ar.${news.advice}`) : '',
      news.isBetter ? text('ar.better') : '',
    ].filter((part) => part !== '').join(' ');
    if (words !== '') {
      this.say(words, news.advice ? 'alert' : 'none');
    }
  }

  private async endSession(): Promise<void> {
    this.isEnding = true;
    await this.ar?.end();
    this.isEnding = false;
  }

  private async ended(): Promise<void> {
    this.ar = null;
    void this.phone.use(this.camera, false);
    if (!this.isEnding) {
      this.phone.setWaits(this.isRecorded);
      this.say(text(this.isRecorded ? 'ar.paused' : 'ar.closed'), 'alert', 'answer');
    }
    const failure = await this.camera.letGo();
    if (failure) {
      this.phone.say(`device.camera_${failure}`);
    }
  }

  private hearJob(job: Job): void {
    const { kind, state } = job;
    if (kind === 'map' && state !== 'running' && this.waitsForMap) {
      this.waitsForMap = false;
      const words = [text(`job.map_${state}`), state === 'done' ? text('ar.next') : wordsOfEnd(job)];
      this.say(words.join(' '), state === 'done' ? 'back' : 'alert');
    }
  }

  private say(words: string, sound: 'alert' | 'back' | 'none' = 'none', priority: 'notice' | 'answer' = 'notice'): void {
    this.player.push({ ...ownNotice('walk', words, performance.now()), sound, priority });
  }
}

// Folders are called so: no slash, and no two alike.
export function nameOfWalk(now: Date): string {
  const two = (value: number): string => String(value).padStart(2, '0');
  const date = `${now.getFullYear()}-${two(now.getMonth() + 1)}-${two(now.getDate())}`;
  return `${text('record.default_name')} ${date} ${two(now.getHours())}.${two(now.getMinutes())}.${two(now.getSeconds())}`;
}

const kApps: TextKey[] = ['apps.scanner', 'apps.stray', 'apps.record3d', 'apps.polycam'];

function openAdvice(role: Role): void {
  openDialog(text('apps.title'), [
    h('p', {}, text('apps.why')),
    h('p', {}, text('apps.which')),
    h('ul', { class: 'apps' }, ...kApps.map((app) => h('li', {}, text(app)))),
    role === 'helper' ? h('p', {}, h('a', { href: at('/#walks') }, text('apps.hand_in'))) : h('p', {}, text('apps.ask_helper')),
  ]);
}

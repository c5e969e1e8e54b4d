// Beginning a home with photos: a guided turn on the spot in each room, dark and blurred pictures refused at once.
import { ApiError, messageOf, request, showWhy } from '../shared/api';
import { Camera } from '../shared/camera';
import { openDialog } from '../shared/dialog';
import { h } from '../shared/dom';
import { textField } from '../shared/forms';
import { greyFromRgba, measureQuality, troubleOf, type GreyPicture } from '../shared/picture_quality';
import { kGreySide } from '../shared/picture_source';
import { showsTheSame } from '../shared/same_view';
import { counted, text } from '../shared/texts';
import { actOrSay, type Helper } from './actions';
import { required } from '../shared/form_dialog';
import { rerender } from './rerender';
import { card } from './shell';

interface PhotosOf {
  room: string;
  photos: number;
}
interface Added extends PhotosOf {
  wanted: number;
}

export function photosCard(helper: Helper): HTMLElement {
  const room = textField(text('photos.room'), { hint: text('photos.room_hint'), attributes: { maxlength: 60 } });
  const files = textField(text('photos.files'), {
    hint: text('photos.files_hint'), attributes: { type: 'file', accept: 'image/*', multiple: true },
  });
  const list = h('ul', { class: 'ranges' });
  const turn = h('button', { type: 'submit', class: 'primary' }, text('photos.turn'));
  const add = h('button', { type: 'button', onclick: () => void addFiles() }, text('photos.add'));
  const form = h('form', { novalidate: true, class: 'form' }, room.element, h('div', { class: 'row' }, turn), files.element,
    h('div', { class: 'row' }, add));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    room.clear();
    if (required(room, text('photos.room_missing'))) {
      openTurn(room.value(), showPhotos);
    }
  });

  async function addFiles(): Promise<void> {
    [room, files].forEach((field) => field.clear());
    const chosen = [...((files.input as HTMLInputElement).files ?? [])];
    if (!required(room, text('photos.room_missing'))) {
      return;
    }
    if (chosen.length === 0) {
      files.fail(text('photos.files_missing'));
      return;
    }
    const refused = new Map<string, string[]>(); // why, and which files
    let added: Added | null = null;
    let isGone: unknown = null; // why none of those that are left comes through
    for (const file of chosen) {
      try {
        if (isGone !== null) {
          throw isGone;
        }
        added = await addFile(room.value(), file);
      } catch (error) {
        if (error instanceof ApiError && error.status === 0) {
          isGone = error;
        }
        refused.set(messageOf(error), [...refused.get(messageOf(error)) ?? [], file.name]);
      }
    }
    showPhotos();
    if (added) {
      helper.announcer.say(wordsOf(added, ''));
    }
    if (refused.size > 0) {
      files.fail([...refused].map(([why, names]) => `${names.join(', ')}: ${why}`).join(' '));
    }
  }

  function showPhotos(): void {
    request<{ rooms: PhotosOf[]; wanted: number }>('GET', '/api/photos').then(({ rooms, wanted }) => {
      rerender(list, rooms.map(({ room: name, photos }) => {
        const remove = (): void => actOrSay(helper,
          () => request('DELETE', `/api/rooms/${encodeURIComponent(name)}/photos`).then(showPhotos), text('photos.removed', { room: name }));
        return h('li', {},
          h('span', {}, `${name}: ${counted('photos.count', photos)}${photos < wanted ? `, ${counted('photos.missing', wanted - photos)}` : ''}`),
          h('button', { type: 'button', class: 'small', 'data-key': `photos ${name}`, 'aria-label': `${text('photos.remove')} ${name}`, onclick: remove }, text('photos.remove')));
      }));
    }).catch(() => undefined); // shown with the next change
  }

  helper.store.watch(['home', 'online'], showPhotos);
  return card(text('photos.heading'), h('p', { class: 'hint' }, text('photos.explain')), form, list);
}

// A dialog with the camera's picture and one large button.
function openTurn(room: string, changed: () => void): void {
  const video = h('video', { class: 'turn-picture', playsinline: true, muted: true, 'aria-hidden': 'true', tabindex: '-1' });
  video.muted = true;
  const camera = new Camera(video);
  const news = h('p', { class: 'turn-news', role: 'status' });
  const shoot = h('button', { type: 'button', class: 'primary big', autofocus: true, onclick: () => void take() }, text('photos.take'));
  let last: GreyPicture | null = null;
  let isTaking = false;

  // The same words twice are read twice.
  const say = (words: unknown): void => {
    const line = h('span');
    showWhy(line, words);
    news.replaceChildren(line);
  };

  async function take(): Promise<void> {
    if (isTaking) {
      return;
    }
    isTaking = true;
    try {
      const grey = camera.grey();
      const picture = grey && await camera.frame();
      if (!grey || !picture) {
        say(text('photos.no_camera'));
        return;
      }
      const refusal = refusalOf(grey, last);
      if (refusal) {
        say(refusal);
        return;
      }
      const added = await post(room, new Blob([picture.color as BlobPart], { type: 'image/jpeg' }));
      last = grey;
      say(wordsOf(added, text('photos.turn_on')));
      changed();
    } catch (error) {
      say(error);
    } finally {
      isTaking = false;
    }
  }

  openDialog(text('photos.turn_title', { room }), [
    h('p', {}, text('photos.turn_explain')), video, news, shoot,
  ], () => {
    camera.stop();
    changed();
  });
  void camera.start().then((failure) => {
    if (failure) {
      say(text(failure === 'refused' ? 'photos.camera_refused' : 'photos.no_camera'));
    }
  });
}

// `next`: what the person is to do for the next one; may be empty.
function wordsOf({ photos, wanted }: Added, next: string): string {
  const left = wanted - photos;
  const then = left > 0 ? [next, sentence(counted('photos.missing', left))] : [text('photos.enough')];
  return [`${counted('photos.count', photos)}.`, ...then].filter((part) => part !== '').join(' ');
}

function sentence(words: string): string {
  return `${words.charAt(0).toUpperCase()}${words.slice(1)}.`;
}

function refusalOf(grey: GreyPicture, last: GreyPicture | null): string | null {
  const trouble = troubleOf(measureQuality(grey));
  if (trouble) {
    return text(`photos.${trouble}`);
  }
  return last && showsTheSame(last, grey) ? text('photos.same') : null;
}

function post(room: string, photo: Blob): Promise<Added> {
  return request<Added>('POST', `/api/rooms/${encodeURIComponent(room)}/photos`, photo);
}

const kPhotoSide = 1024; // longest, pixels: networks look at less

// Brought to a size that is sent quickly; what the phone writes into a photo beside the picture is left behind.
async function addFile(room: string, file: File): Promise<Added> {
  const picture = await createImageBitmap(file).catch(() => {
    throw new Error(text('photos.no_picture'));
  });
  const drawn = (longest: number): HTMLCanvasElement => {
    const scale = Math.min(1, longest / Math.max(picture.width, picture.height));
    const canvas = document.createElement('canvas');
    Object.assign(canvas, { width: Math.round(picture.width * scale), height: Math.round(picture.height * scale) });
    canvas.getContext('2d')?.drawImage(picture, 0, 0, canvas.width, canvas.height);
    return canvas;
  };
  const small = drawn(kGreySide);
  const pixels = small.getContext('2d')?.getImageData(0, 0, small.width, small.height);
  const refusal = pixels && refusalOf(greyFromRgba(pixels.data, small.width, small.height), null);
  if (refusal) {
    throw new Error(refusal);
  }
  const blob = await new Promise<Blob | null>((resolve) => drawn(kPhotoSide).toBlob(resolve, 'image/jpeg', 0.9));
  if (!blob) {
    throw new Error(text('photos.no_picture'));
  }
  return post(room, blob);
}

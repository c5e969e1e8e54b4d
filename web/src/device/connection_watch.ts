// When the connection's state is worth saying: a break that heals at once is not. Pure.

export const kSaidAfterMs = 1500; // after the socket's close

export const kLookEveryMs = 250; // how often the phone looks

export type ConnectionNews = 'lost' | 'back' | null;

export class ConnectionWatch {
  private offlineSince: number | null;
  private saidLost = false;

  constructor(begin: number) {
    this.offlineSince = begin;
  }

  offline(now: number): void {
    this.offlineSince ??= now;
  }

  // Gone for certain: nothing was heard for long enough.
  gone(): ConnectionNews {
    this.offlineSince = -Infinity;
    return this.sayLost();
  }

  online(): ConnectionNews {
    this.offlineSince = null;
    const news = this.saidLost ? 'back' : null;
    this.saidLost = false;
    return news;
  }

  // To be asked a few times a second.
  look(now: number): ConnectionNews {
    const since = this.offlineSince;
    return since !== null && now - since >= kSaidAfterMs ? this.sayLost() : null;
  }

  private sayLost(): ConnectionNews {
    if (this.saidLost) {
      return null;
    }
    this.saidLost = true;
    return 'lost';
  }
}

// The robot programs of a controller, with the line that each task executes now.

import { ListingView } from "./listing.js";

export class Programs {
  #card;
  #host;
  #shown = "";
  #views = new Map();

  constructor(card, host) {
    this.#card = card;
    this.#host = host;
  }

  // Other listings are needed where they are of another controller.
  wants({ id, programs }) {
    return this.#shown !== `${id} ${programs}`;
  }

  list({ id, programs }, listings) {
    this.#shown = `${id} ${programs}`;
    this.#views.clear();
    this.#host.replaceChildren();
    for (const { name, file, lines } of listings) {
      if (lines.length) this.#views.set(name, new ListingView(this.#host, { title: file ?? name, lines }));
    }
    this.#host.classList.toggle("several", this.#views.size > 1);
    this.#card.hidden = !this.#views.size;
    this.#card.parentElement.classList.toggle("programmed", this.#views.size > 0);
  }

  show({ tasks }) {
    const places = new Map(tasks.map((task) => [task.program, task]));
    for (const [name, view] of this.#views) view.show(places.get(name) ?? null);
  }
}

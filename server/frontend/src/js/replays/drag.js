// A pose that the reader moves on the drawing, by mouse, by touch or with the keys.

const REACH = 26; // pixels from which the robot can be taken hold of
const TURNS = { g: -1, d: 1 }; // to the left and to the right, as seen: letters that AZERTY and QWERTY have alike
const KEYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class Drag {
  #held = null;

  /** `moved(name, pose)` is told of every change; `held()` when the robot is taken or let go. */
  constructor(stage, { moved, held }) {
    this.stage = stage;
    this.moved = moved;
    this.held = held;
    this.parameter = null;
    const { canvas } = stage;
    canvas.addEventListener("pointerdown", (event) => this.#take(event));
    canvas.addEventListener("pointermove", (event) => this.#follow(event));
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => this.#letGo());
    // A finger on the robot moves it; anywhere else it scrolls the page.
    canvas.addEventListener("touchstart", (event) => this.#held && event.preventDefault(), { passive: false });
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
  }

  /** The pose that can be dragged, and where it is; null when the scene has none. */
  watch(parameter, pose) {
    this.parameter = parameter;
    this.pose = pose;
    this.stage.canvas.classList.toggle("replay-draggable", Boolean(parameter));
  }

  /** Where the reader holds the robot, when that is not where it is. */
  get wish() {
    return this.#held?.wish ?? null;
  }

  /** True when a key moved the robot. */
  key(event) {
    if (!this.parameter) return false;
    const [x, y, angle] = this.pose;
    const stride = (event.shiftKey ? 20 : 5) * this.parameter.step;
    const turn = TURNS[event.key.toLowerCase()];
    if (turn && this.parameter.turns) {
      this.#move(x, y, angle + 2 * turn * this.stage.paper.turn * this.parameter.turn);
    } else if (KEYS[event.key]) {
      const [right, down] = KEYS[event.key];
      this.#move(x + stride * right, y + stride * down * this.stage.paper.turn, angle);
    } else return false;
    return true;
  }

  #place(event) {
    const box = this.stage.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  #take(event) {
    if (!this.parameter || !event.isPrimary) return;
    const [px, py] = this.#place(event);
    const { paper } = this.stage;
    const [x, y, angle] = this.pose;
    const [dx, dy] = [px - paper.x(x), py - paper.y(y)];
    const radius = Math.max(10, 0.4 * paper.scale);
    const tip = [Math.cos(angle), paper.turn * Math.sin(angle)].map((part) => 1.25 * radius * part);
    const turning = this.parameter.turns && Math.hypot(dx - tip[0], dy - tip[1]) < 0.75 * radius;
    if (!turning && Math.hypot(dx, dy) > Math.max(REACH, radius)) return;
    this.#held = { turning, offset: [dx, dy], wish: null };
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.held(true);
    event.preventDefault();
  }

  #follow(event) {
    if (!this.#held) return;
    const [px, py] = this.#place(event);
    const { paper } = this.stage;
    const [x, y, angle] = this.pose;
    if (this.#held.turning) {
      this.#move(x, y, paper.turn * Math.atan2(py - paper.y(y), px - paper.x(x)));
      return;
    }
    const [wishX, wishY] = paper.back(px - this.#held.offset[0], py - this.#held.offset[1]);
    this.#held.wish = [wishX, wishY, angle];
    this.#move(wishX, wishY, angle);
  }

  #letGo() {
    if (!this.#held) return;
    this.#held = null;
    this.held(false);
  }

  #wheel(event) {
    if (!this.parameter?.turns || !event.shiftKey) return;
    event.preventDefault();
    const [x, y, angle] = this.pose;
    this.#move(x, y, angle + 2 * this.parameter.turn * Math.sign(event.deltaY || event.deltaX));
  }

  #move(x, y, angle) {
    const [x0, y0, x1, y1] = this.parameter.box;
    const within = (value, low, high) => Math.min(Math.max(value, low), high);
    const wrapped = Math.atan2(Math.sin(angle), Math.cos(angle));
    this.pose = [within(x, x0, x1), within(y, y0, y1), wrapped].map((one) => Number(one.toFixed(4)));
    this.moved(this.parameter.name, this.pose);
  }
}

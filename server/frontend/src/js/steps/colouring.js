// Python in the colours that the editor gives it, by the same mode; without the editor, of which a page to read has none.

import { python } from "@codemirror/legacy-modes/mode/python";

const TAB = 4;
const LONGEST = 1000; // characters of a line that somebody reads

/** Of each line, its pieces as [text, kind]; the kind is empty for what has no colour. */
export function coloured(lines) {
  const state = python.startState(TAB);
  return lines.map((text) => {
    if (text === "" || text.length > LONGEST) return [];
    const line = new Line(text);
    const pieces = [];
    while (!line.eol()) {
      line.start = line.pos;
      const kind = python.token(line, state) ?? "";
      if (line.pos === line.start) line.next(); // a mode that stands still is not waited for
      pieces.push([line.current(), kind]);
    }
    return pieces;
  });
}

/** What a mode reads a line from: those methods of CodeMirror's stream that it calls. */
class Line {
  pos = 0;
  start = 0;
  indentUnit = TAB;

  constructor(text) {
    this.text = text;
  }

  eol() {
    return this.pos >= this.text.length;
  }

  sol() {
    return this.pos === 0;
  }

  peek() {
    return this.text[this.pos];
  }

  next() {
    return this.text[this.pos++];
  }

  current() {
    return this.text.slice(this.start, this.pos);
  }

  eat(wanted) {
    const sign = this.peek();
    const found = sign !== undefined && (typeof wanted === "string" ? sign === wanted : wanted.test(sign));
    return found ? this.next() : undefined;
  }

  eatWhile(wanted) {
    const from = this.pos;
    while (this.eat(wanted));
    return this.pos > from;
  }

  eatSpace() {
    return this.eatWhile(/\s/);
  }

  match(wanted, consume = true) {
    const rest = this.text.slice(this.pos);
    const found = typeof wanted === "string" ? rest.startsWith(wanted) && [wanted] : rest.match(wanted);
    if (!found || found.index > 0) return null;
    if (consume) this.pos += found[0].length;
    return found;
  }

  column() {
    return width(this.text.slice(0, this.start));
  }

  indentation() {
    return width(this.text.match(/^\s*/)[0]);
  }
}

function width(text) {
  return [...text].reduce((sum, sign) => (sign === "\t" ? sum + TAB - (sum % TAB) : sum + 1), 0);
}

// The pages to read. Without this script they can be read just as well.

import { setUpContents } from "./reading/contents.js";
import { setUpQuestions } from "./reading/asked.js";
import { setUpCopying } from "./reading/copy.js";
import { setUpDrawings } from "./reading/drawings.js";
import { setUpFormulas } from "./reading/formulas.js";
import { setUpPrinting } from "./reading/print.js";
import { setUpReadMarks, showCourseMarks } from "./reading/marks.js";
import { setUpTerms } from "./reading/terms.js";

const reading = document.querySelector("[data-reading]");
const course = document.querySelector("[data-course]");

if (reading) {
  setUpCopying(reading);
  setUpDrawings(reading);
  setUpTerms(reading);
  setUpContents(reading);
  setUpReadMarks(reading);
  setUpPrinting(reading);
  setUpFormulas(reading);
  setUpQuestions(reading);
  if (reading.querySelector("section.cell")) import("./cells.js").then(({ enhance }) => enhance(reading));
  if (reading.querySelector("figure.manipulation")) {
    import("./manipulations/index.js").then(({ enhance }) => enhance(reading));
  }
  if (reading.querySelector("figure.replay[data-source]")) import("./replays/index.js").then(({ enhance }) => enhance(reading));
}
if (course) showCourseMarks(course);

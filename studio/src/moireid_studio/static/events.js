// What a check reports: what is seen, answers to prompts, the verdict with its reasons.
export const $ = (id) => document.getElementById(id);
const MARKS = { pass: "✓", fail: "✗", undecided: "?", note: "·" };
const WORDS = { pass: "holds", fail: "fails", undecided: "undecided", note: "note" };

export function say(problem) {
  $("problem").textContent = problem || "";
  $("problem").hidden = !problem;
}

export function state(id, value) {
  $(id).dataset.state = value;
}

/** The running state: badge, face, law; gives the worst finding, where one is not good. */
export function seen(event) {
  state("see-badge", event.badge ? "pass" : "undecided");
  state("see-face", event.face ? "pass" : "undecided");
  state("see-law", { accept: "pass", reject: "fail", inconclusive: "undecided" }[event.verdict]);
  return event.reasons.find((one) => one.level === "fail") || event.reasons.find((one) => one.level === "undecided");
}

export function clear() {
  for (const id of ["see-badge", "see-face", "see-law"]) state(id, "");
  $("prompts").replaceChildren();
}

export function answered(reason) {
  const line = document.createElement("li"), mark = document.createElement("span");
  mark.className = "mark " + reason.level;
  mark.textContent = MARKS[reason.level] + " ";
  line.append(mark, reason.text);
  $("prompts").append(line);
}

export function judged(event) {
  const { headline } = event;
  $("verdict").className = "verdict " + headline.colour;
  $("verdict-words").textContent = `${headline.mark} ${headline.title}`;
  $("verdict-text").textContent = headline.text;
  $("verdict-next").textContent = headline.advice;
  $("reasons").replaceChildren(...event.reasons.map((reason) => {
    const row = document.createElement("tr"), mark = document.createElement("td"), words = document.createElement("td");
    mark.className = "mark " + reason.level;
    mark.textContent = `${MARKS[reason.level]} ${WORDS[reason.level]}`;
    words.textContent = reason.text;
    row.append(mark, words);
    return row;
  }));
  $("result").hidden = false;
  $("result").focus();
}

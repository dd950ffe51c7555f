// The survey: the participant, the questions one by one, and a file of answers.

const survey = JSON.parse(document.getElementById("data").textContent);
// The names of the models, which participants must not see.
const models = JSON.parse(new TextDecoder().decode(Uint8Array.from(atob(survey.key), (letter) => letter.charCodeAt(0))));
const questions = survey.questions;
const get = (id) => document.getElementById(id);
const player = new Player(get("player"), survey.figure, { abreast: true });

let state = { participant: "", answers: {} };

// The state is kept in IndexedDB: for a page opened as a file, localStorage may be outdated or empty when the page is
// opened again (seen in Chromium 156, one time in four).
let database = null;

function request(asked) {
  return new Promise((resolve, reject) => {
    asked.onsuccess = () => resolve(asked.result);
    asked.onerror = () => reject(asked.error);
  });
}

async function recall() {
  try {
    const opening = indexedDB.open("npss-survey", 1);
    opening.onupgradeneeded = () => opening.result.createObjectStore("states");
    database = await request(opening);
    state = (await request(database.transaction("states").objectStore("states").get(survey.id))) ?? state;
  } catch {
    // No database, or an unreadable state: the survey starts again.
  }
}

function keep() {
  try {
    const transaction = database.transaction("states", "readwrite");
    transaction.objectStore("states").put(state, survey.id);
    transaction.commit(); // do not wait: the page may be closed first
  } catch {
    // Answers last while the page is open.
  }
}

let at = -1; // -1: the start; the number of questions: the end

function show(step) {
  at = step;
  const asking = at >= 0 && at < questions.length;
  get("start").hidden = at !== -1;
  get("question").hidden = !asking;
  get("end").hidden = at !== questions.length;
  for (const alert of document.querySelectorAll(".alert")) alert.textContent = "";
  if (!asking) {
    player.pause();
    if (at === questions.length) get("end-title").focus();
    return;
  }
  const { truth, a, b } = questions[at];
  get("number").textContent = `Question ${at + 1} of ${questions.length}`;
  get("progress").value = Object.keys(state.answers).length;
  for (const choice of document.querySelectorAll("input[name=choice]")) {
    choice.checked = state.answers[at] === choice.value;
  }
  get("next").textContent = at === questions.length - 1 ? "Finish" : "Next";
  player.show([
    { label: "Ground truth", truth: true, motion: survey.motions[truth] },
    { label: "A", truth: false, motion: survey.motions[a] },
    { label: "B", truth: false, motion: survey.motions[b] },
  ]);
  get("number").focus();
}

function firstOpen() {
  const open = questions.findIndex((_, i) => !(i in state.answers));
  return open === -1 ? questions.length : open;
}

function csv() {
  const quoted = (value) => (/[",\r\n]|^\s|\s$/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
  const rows = questions.map(({ number, sequence, model_a, model_b }, i) => [
    survey.action,
    number,
    sequence,
    models[model_a],
    models[model_b],
    state.participant,
    state.answers[i],
  ]);
  const header = ["action", "question", "sequence", "model_a", "model_b", "participant", "choice"];
  return [header, ...rows].map((row) => `${row.map((value) => quoted(String(value))).join(",")}\r\n`).join("");
}

get("start-form").addEventListener("submit", (event) => {
  event.preventDefault();
  const name = get("participant").value.trim();
  if (!name) {
    get("start-alert").textContent = "Please give a name or number.";
    get("participant").focus();
    return;
  }
  state.participant = name;
  keep();
  show(firstOpen());
});

get("question-form").addEventListener("change", (event) => {
  if (event.target.name !== "choice") return;
  state.answers[at] = event.target.value;
  get("question-alert").textContent = "";
  get("progress").value = Object.keys(state.answers).length;
  keep();
});

get("question-form").addEventListener("submit", (event) => {
  event.preventDefault();
  if (!(at in state.answers)) get("question-alert").textContent = "Please choose A or B.";
  else show(at + 1);
});

for (const back of document.querySelectorAll(".back")) back.addEventListener("click", () => show(at - 1));

get("save").addEventListener("click", () => {
  const address = URL.createObjectURL(new Blob([csv()], { type: "text/csv" }));
  const tame = (text) => text.replaceAll(/[^\p{L}\p{N}_-]+/gu, "-");
  element("a", { href: address, download: `answers-${tame(survey.action)}-${tame(state.participant)}.csv` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
});

get("again").addEventListener("click", () => {
  state = { participant: "", answers: {} };
  keep();
  get("participant").value = "";
  show(-1);
  get("participant").focus();
});

get("progress").max = questions.length;
recall().then(() => {
  get("participant").value = state.participant;
  show(state.participant ? firstOpen() : -1);
});

// The survey: the participant, the questions one by one, and a file of answers.

const survey = JSON.parse(document.getElementById("data").textContent);
// What participants must not see: the models of each question, and the answers to attention checks.
const key = JSON.parse(new TextDecoder().decode(Uint8Array.from(atob(survey.key), (letter) => letter.charCodeAt(0))));
const texts = survey.texts;
const count = survey.questions.length;
const get = (id) => document.getElementById(id);
const player = new Player(get("player"), survey.figure, { abreast: true, words: texts });

// Answers by participant, each a list in the order of that participant's survey; one entry for each question so far.
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

const answers = () => (state.answers[state.participant] ??= {});

// The question at a place in the survey of the present participant, with its sides as shown.
function question(place) {
  const order = survey.orders[(Number(state.participant) - 1) % survey.orders.length];
  const index = order[place] >> 1;
  const mirrored = order[place] & 1; // the last bit: the sides are swapped
  const { action, number, sequence, truth, a, b } = survey.questions[index];
  const [modelA, modelB, expected] = key[index];
  const other = { A: "B", B: "A" };
  return mirrored
    ? { action, number, sequence, truth, a: b, b: a, modelA: modelB, modelB: modelA, expected: other[expected] ?? "" }
    : { action, number, sequence, truth, a, b, modelA, modelB, expected: expected ?? "" };
}

let at = -1; // -1: the start; the number of questions: the end

function show(step) {
  at = step;
  const asking = at >= 0 && at < count;
  get("start").hidden = at !== -1;
  get("question").hidden = !asking;
  get("end").hidden = at !== count;
  for (const alert of document.querySelectorAll(".alert")) alert.textContent = "";
  if (!asking) {
    player.pause();
    if (at === count) get("end-title").focus();
    return;
  }
  const { action, truth, a, b } = question(at);
  const { name, inPlace } = survey.actions[action];
  get("number").textContent = fill(texts.number, { number: at + 1, questions: count });
  get("action").textContent = inPlace ? `${name}. ${texts.in_place}` : name;
  get("progress").value = Object.keys(answers()).length;
  for (const choice of document.querySelectorAll("input[name=choice]")) {
    choice.checked = answers()[at] === choice.value;
  }
  get("next").textContent = at === count - 1 ? texts.finish : texts.next;
  player.show([
    { label: texts.recording, truth: true, motion: survey.motions[truth] },
    { label: texts.left, truth: false, motion: survey.motions[a] },
    { label: texts.right, truth: false, motion: survey.motions[b] },
  ]);
  get("number").focus();
}

function firstOpen() {
  const open = Array.from({ length: count }, (_, i) => i).find((i) => !(i in answers()));
  return open ?? count;
}

function csv() {
  const quoted = (value) => (/[",\r\n]|^\s|\s$/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
  const rows = Array.from({ length: count }, (_, i) => {
    const { action, number, sequence, modelA, modelB, expected } = question(i);
    const { participant } = state;
    return [survey.actions[action].action, number, sequence, modelA, modelB, participant, answers()[i], i + 1, expected];
  });
  return [survey.columns, ...rows].map((row) => `${row.map((value) => quoted(String(value))).join(",")}\r\n`).join("");
}

get("start-form").addEventListener("submit", (event) => {
  event.preventDefault();
  const number = get("participant").value.trim();
  const consent = get("consent");
  if (consent && !consent.checked) {
    get("start-alert").textContent = texts.consent_missing;
    consent.focus();
    return;
  }
  if (!/^[1-9][0-9]{0,8}$/.test(number)) {
    get("start-alert").textContent = texts.participant_missing;
    get("participant").focus();
    return;
  }
  state.participant = number;
  keep();
  show(firstOpen());
});

get("question-form").addEventListener("change", (event) => {
  if (event.target.name !== "choice") return;
  answers()[at] = event.target.value;
  get("question-alert").textContent = "";
  get("progress").value = Object.keys(answers()).length;
  keep();
});

get("question-form").addEventListener("submit", (event) => {
  event.preventDefault();
  if (!(at in answers())) get("question-alert").textContent = texts.choice_missing;
  else show(at + 1);
});

for (const back of document.querySelectorAll(".back")) back.addEventListener("click", () => show(at - 1));

get("save").addEventListener("click", () => {
  const address = URL.createObjectURL(new Blob([csv()], { type: "text/csv" }));
  const tame = (text) => text.replaceAll(/[^\p{L}\p{N}_-]+/gu, "-");
  const actions = survey.actions.map(({ action }) => tame(action)).join("-");
  element("a", { href: address, download: `answers-${actions.slice(0, 60)}-${state.participant}.csv` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
});

get("again").addEventListener("click", () => {
  state.participant = "";
  keep();
  get("participant").value = "";
  if (get("consent")) get("consent").checked = false;
  show(-1);
  get("participant").focus();
});

get("progress").max = count;
recall().then(() => {
  get("participant").value = state.participant || location.hash.slice(1);
  show(state.participant ? firstOpen() : -1);
});

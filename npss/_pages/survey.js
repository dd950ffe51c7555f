// The survey: the participant, the questions one by one, and a file of answers.

const survey = JSON.parse(document.getElementById("data").textContent);
// What participants must not see: the models of each question, and the answers to attention checks.
const key = JSON.parse(new TextDecoder().decode(Uint8Array.from(atob(survey.key), (letter) => letter.charCodeAt(0))));
const texts = survey.texts;
const count = survey.questions.length;
const get = (id) => document.getElementById(id);
const player = new Player(get("player"), survey.figure, { abreast: true, words: texts });

// The present participant, and the answers of each, by place in that participant's survey. A tab keeps only those of its
// present participant, so several tabs do not overwrite each other.
let participant = "";
const answersOf = {};

// They are kept in IndexedDB: for a page opened as a file, localStorage may be outdated or empty when the page is
// opened again (seen in Chromium 156, one time in four).
let database = null;

function request(asked) {
  return new Promise((resolve, reject) => {
    asked.onsuccess = () => resolve(asked.result);
    asked.onerror = () => reject(asked.error);
  });
}

async function openDatabase() {
  try {
    const opening = indexedDB.open("npss-surveys", 1);
    opening.onupgradeneeded = () => opening.result.createObjectStore("surveys");
    database = await request(opening);
  } catch {
    // No database: answers last while the page is open.
  }
}

async function recall(name) {
  try {
    return await request(database.transaction("surveys").objectStore("surveys").get([survey.id, name]));
  } catch {
    return undefined; // no database, or an unreadable entry
  }
}

function keep() {
  try {
    const transaction = database.transaction("surveys", "readwrite");
    const store = transaction.objectStore("surveys");
    store.put(participant, [survey.id, "participant"]);
    if (participant) store.put(answers(), [survey.id, participant]);
    transaction.commit(); // do not wait: the page may be closed first
  } catch {
    // Answers last while the page is open.
  }
}

const answers = () => (answersOf[participant] ??= {});

// The question at a place in the survey of the present participant, with its sides as shown.
function question(place) {
  const order = survey.orders[(Number(participant) - 1) % survey.orders.length];
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
  get("action").textContent = `${name}. ${inPlace ? texts.in_place : texts.path}`;
  get("who").textContent = fill(texts.who, { participant });
  get("progress").value = Object.keys(answers()).length;
  for (const choice of document.querySelectorAll("input[name=choice]")) {
    choice.checked = answers()[at] === choice.value;
  }
  get("next").textContent = at === count - 1 ? texts.finish : texts.next;
  const panels = [
    { label: texts.recording, truth: true, motion: survey.motions[truth] },
    { label: texts.left, truth: false, motion: survey.motions[a] },
    { label: texts.right, truth: false, motion: survey.motions[b] },
  ];
  player.show(truth === null ? panels.slice(1) : panels);
  get("number").focus();
}

// A participant's number.
const NUMBER = /^[1-9][0-9]{0,8}$/;

// The address may hold the number of a participant, as in survey.html#7. If another was here last, ask who it is.
async function enter() {
  const asked = location.hash.slice(1);
  const last = participant || ((await recall("participant")) ?? "");
  if (last && (asked === last || !NUMBER.test(asked))) await begin(last);
  else greet(asked);
}

// Show the start, with a number to confirm.
function greet(number) {
  get("participant").value = number;
  if (get("consent")) get("consent").checked = false;
  show(-1);
}

// Go on with the survey of a participant where it was left.
async function begin(number) {
  answersOf[number] = (await recall(number)) ?? answersOf[number];
  become(number);
  get("participant").value = number;
  show(firstOpen());
}

// Let a participant be the present one, also in an address that names another.
function become(number) {
  participant = number;
  keep();
  if (location.hash) history.replaceState(null, "", `#${number}`);
}

function firstOpen() {
  const open = Array.from({ length: count }, (_, i) => i).find((i) => !(i in answers()));
  return open ?? count;
}

function csv() {
  const quoted = (value) => (/[",\r\n]|^\s|\s$/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
  const rows = Array.from({ length: count }, (_, i) => {
    const { action, number, sequence, modelA, modelB, expected } = question(i);
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
  if (!NUMBER.test(number)) {
    get("start-alert").textContent = texts.participant_missing;
    get("participant").focus();
    return;
  }
  begin(number);
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
  element("a", { href: address, download: `answers-${actions.slice(0, 60)}-${participant}.csv` }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
});

get("again").addEventListener("click", () => {
  become("");
  greet("");
  get("participant").focus();
});

addEventListener("hashchange", enter);

get("progress").max = count;
openDatabase().then(enter);

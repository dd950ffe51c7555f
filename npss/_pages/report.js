// The report: choose motions, and copy signatures.

const report = JSON.parse(document.getElementById("data").textContent);

if (report.clips.length > 0) {
  const player = new Player(document.getElementById("player"), report.figure);
  const [action, sequence] = ["action", "sequence"].map((id) => document.getElementById(id));
  const show = () =>
    player.show(
      report.clips[action.value].motions.map(({ label, sequences }, i) => ({
        label,
        truth: i === 0,
        motion: sequences[sequence.value],
      })),
    );
  const choose = () => {
    const count = report.clips[action.value].motions[0].sequences.length;
    sequence.replaceChildren(
      ...Array.from({ length: count }, (_, i) => element("option", { value: i }, String(i))),
    );
    show();
  };
  action.append(...report.clips.map(({ name }, i) => element("option", { value: i }, name)));
  action.addEventListener("change", choose);
  sequence.addEventListener("change", show);
  choose();
}

for (const button of document.querySelectorAll("button.copy")) {
  const code = button.parentElement.querySelector("code");
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(code.textContent);
      button.textContent = "Copied";
    } catch {
      getSelection().selectAllChildren(code); // then a key press copies it
      button.textContent = "Selected";
    }
    setTimeout(() => (button.textContent = "Copy"), 2000);
  });
}

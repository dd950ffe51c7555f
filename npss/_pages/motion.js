// Motions side by side.

const shown = JSON.parse(document.getElementById("data").textContent);
new Player(document.getElementById("player"), shown.figure).show(shown.panels);

// Begin: what moves shows itself.
"use strict";

{
  const stored = document.getElementById("living-data");
  const root = document.getElementById("live");
  showValues();
  sortTables();
  if (stored && root) {
    const data = JSON.parse(stored.textContent);
    globalThis.living = data.kind === "study" ? new LivingStudy(data, root) : new LivingYear(data, root);
  }
}

"use strict";
// Keys: n and p go through the lines that are not covered, i to the list of all files.
const open_ = [...document.querySelectorAll("tr.bad")];
const back = document.getElementById("back");
let at = open_.findIndex((line) => "#" + line.id === location.hash);
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "i" && back) back.click();
  if (!open_.length || !"np".includes(event.key)) return;
  const first = at < 0 && event.key === "p" ? 0 : at;
  at = (first + (event.key === "n" ? 1 : -1) + open_.length) % open_.length;
  history.replaceState(null, "", "#" + open_[at].id);
  open_.forEach((line, number) => line.classList.toggle("here", number === at));
  open_[at].scrollIntoView({ block: "center" });
});

"use strict";
// what an address names is opened, with all that it is folded in; without this script a reader opens it by hand
function reveal() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  for (let fold = target; fold; fold = fold.parentElement) {
    if (fold instanceof HTMLDetailsElement) fold.open = true;
  }
  if (target) target.scrollIntoView();
}
addEventListener("hashchange", reveal);
// the same address once more is no change of it
addEventListener("click", (event) => {
  const link = event.target.closest && event.target.closest('a[href^="#"]');
  if (link && link.hash === location.hash) reveal();
});
reveal();

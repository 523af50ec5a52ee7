// Light or dark theme, as chosen on the site. The site stores the choice under this key.
const KEY = `${new URL("..", location).pathname}.__palette`;
const DARK = matchMedia("(prefers-color-scheme: dark)");
const FOLLOWS_SYSTEM = "(prefers-color-scheme)";

/** Return the stored choice of the site, or an empty object. */
function stored() {
  try {
    return JSON.parse(localStorage.getItem(KEY))?.color ?? {};
  } catch {
    return {}; // the browser stores nothing, or the entry is damaged
  }
}

/** Return "light" or "dark". */
export function theme() {
  const { media, scheme } = stored();
  const dark = scheme && media !== FOLLOWS_SYSTEM ? scheme === "slate" : DARK.matches;
  return dark ? "dark" : "light";
}

/** Apply the theme to this page now and after each change, and pass every change to `changed`. */
export function onTheme(changed) {
  const apply = () => (document.documentElement.style.colorScheme = theme());
  const update = () => changed(apply());
  apply();
  DARK.addEventListener("change", update);
  addEventListener("storage", (event) => event.key === KEY && update()); // from other frames and tabs
}

/* The settings in the fragment of the address, so that a link reproduces them. */

let pending = 0;

/** Returns the settings of the address, by name, as text. */
export function readLink() {
  return Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
}

/** Puts what `settings()` returns into the address, soon: browsers allow that only so often. */
export function writeLink(settings) {
  clearTimeout(pending);
  pending = setTimeout(() => {
    history.replaceState(null, "", `#${new URLSearchParams(settings())}`);
  }, 250);
}

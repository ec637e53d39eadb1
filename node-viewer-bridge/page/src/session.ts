// Who this browser is to the bridge. On the bridge's own machine nobody has to say; elsewhere a token does, typed in or
// behind `#token=` in the link that a person was given. The bridge then keeps it in a cookie that no script can read.

import { find } from "./panels/dom.ts";

const PATH = "api/session";

/** Whether the bridge wants a token first. A bridge that does not answer wants none yet. */
export async function wantsToken(ask: typeof fetch = fetch): Promise<boolean> {
  const answer = await ask(PATH, { cache: "no-store" }).catch(() => null);
  return answer?.status === 401 || answer?.status === 429;
}

/** Says a token; why it is not taken, or nothing. */
export async function sayToken(token: string, ask: typeof fetch = fetch): Promise<string | null> {
  const headers = { "content-type": "application/json" };
  const answer = await ask(PATH, { method: "POST", headers, body: JSON.stringify({ token }) }).catch(() => null);
  if (answer === null) return "The bridge does not answer.";
  if (answer.ok) return null;
  if (answer.status === 429) return "Too many wrong tokens from this address. Wait a minute.";
  return answer.status === 401 ? "This is no token of this page." : `The bridge answered ${answer.status}.`;
}

/** The token in a link's fragment. */
export function tokenIn(hash: string): string | null {
  return /^#(?:.*&)?token=([A-Za-z0-9]+)/.exec(hash)?.[1] ?? null;
}

/** Comes back when this browser may look. */
export async function enter(): Promise<void> {
  const token = tokenIn(location.hash);
  if (token !== null) {
    // Out of the address bar, and of what people copy from there.
    history.replaceState(null, "", location.pathname + location.search);
    if ((await sayToken(token)) === null) return;
  }
  if (await wantsToken()) await loggedIn();
}

function loggedIn(): Promise<void> {
  const form = find<HTMLFormElement>("form[data-testid=login]");
  const field = find<HTMLInputElement>("input", form);
  const complaint = find<HTMLElement>("[role=alert]", form);
  form.hidden = false;
  field.focus();
  return new Promise((done) => {
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void sayToken(field.value.trim()).then((cause) => {
        complaint.textContent = cause ?? "";
        if (cause !== null) return field.select();
        form.hidden = true;
        field.value = "";
        done();
      });
    });
  });
}

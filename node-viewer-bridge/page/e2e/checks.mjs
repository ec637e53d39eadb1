// Checks of a page, a line each on stderr.

let failed = false;

export async function check(name, action) {
  try {
    await action();
    console.error(`ok   ${name}`);
  } catch (error) {
    fail(`${name}: ${error.message.split("\n")[0]}`);
  }
}

export function fail(words) {
  failed = true;
  console.error(`FAIL ${words}`);
}

/** Ends with exit code 1 when one failed. */
export const end = () => process.exit(failed ? 1 : 0);

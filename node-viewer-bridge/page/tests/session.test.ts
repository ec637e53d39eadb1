import assert from "node:assert/strict";
import test from "node:test";
import { sayToken, tokenIn, wantsToken } from "../src/session.ts";

const answering = (status: number): typeof fetch => () => Promise.resolve(new Response("{}", { status }));
const silent: typeof fetch = () => Promise.reject(new Error("no network"));

test("a token stands behind the link's #", () => {
  assert.equal(tokenIn("#token=abc123"), "abc123");
  assert.equal(tokenIn("#view=1&token=abc123"), "abc123");
  assert.equal(tokenIn("#token="), null);
  assert.equal(tokenIn("#mytoken=abc"), null);
  assert.equal(tokenIn(""), null);
});

test("a bridge that refuses wants a token, one that is silent does not yet", async () => {
  assert.equal(await wantsToken(answering(401)), true);
  assert.equal(await wantsToken(answering(429)), true);
  assert.equal(await wantsToken(answering(200)), false);
  assert.equal(await wantsToken(silent), false);
});

test("a token that is not taken is complained about", async () => {
  assert.equal(await sayToken("a", answering(200)), null);
  assert.match((await sayToken("a", answering(401))) ?? "", /no token/);
  assert.match((await sayToken("a", answering(429))) ?? "", /minute/);
  assert.match((await sayToken("a", silent)) ?? "", /does not answer/);
});

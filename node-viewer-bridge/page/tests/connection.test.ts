import assert from "node:assert/strict";
import { test } from "node:test";
import { socketUrl } from "../src/connection.ts";

const at = (href: string): string => socketUrl(new URL(href) as unknown as Location, 30);

test("the socket lies beside the page, encrypted where the page is", () => {
  assert.equal(at("http://127.0.0.1:8600/"), "ws://127.0.0.1:8600/ws?max_hz=30");
  assert.equal(at("https://lab.example/viewer/?a=1#b"), "wss://lab.example/viewer/ws?max_hz=30");
});

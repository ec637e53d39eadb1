// The WebSocket to the bridge: keeps trying, answers round trips, skips what the network does not take.

import { nowMs, type Link, type Report } from "./words.ts";

const FIRST_RETRY_MS = 400;
const LAST_RETRY_MS = 5000;
/** The bridge asks every second. */
const SILENCE_MS = 4000;
/** With so many bytes waiting, newer messages are dropped. */
const MOST_WAITING = 64 * 1024;

/** Close codes with a reason for the user: after these the connection is not tried again, after the first it is. */
const POLICY = 1008;
const FINAL = [4000, 4001, 4002];

export class Uplink {
  #socket: WebSocket | null = null;
  #retryMs = FIRST_RETRY_MS;
  #timer = 0;
  #joined = false;

  constructor(
    private readonly url: string,
    private readonly tell: (message: Link | Report) => void,
  ) {
    this.#open();
  }

  get joined(): boolean {
    return this.#joined;
  }

  /** Whether the message is on its way. */
  send(bytes: Uint8Array<ArrayBuffer>): boolean {
    if (!this.#joined || !this.#socket || this.#socket.bufferedAmount > MOST_WAITING) return false;
    this.#socket.send(bytes);
    return true;
  }

  close(): void {
    clearTimeout(this.#timer);
    const socket = this.#socket;
    this.#socket = null;
    this.#joined = false;
    socket?.close();
  }

  #open(): void {
    const socket = new WebSocket(this.url);
    this.tell({ type: "link", condition: "connecting", words: "connecting" });
    socket.onmessage = ({ data }: MessageEvent<unknown>) => socket === this.#socket && this.#take(socket, data);
    socket.onclose = ({ code, reason }) => this.#lost(socket, code === POLICY || FINAL.includes(code) ? reason : "", !FINAL.includes(code));
    this.#socket = socket;
    this.#watch(socket);
  }

  #watch(socket: WebSocket): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#lost(socket, "", true), SILENCE_MS) as unknown as number;
  }

  #take(socket: WebSocket, data: unknown): void {
    const received = nowMs();
    this.#watch(socket);
    const message = parsed(data);
    switch (message?.["type"]) {
      case "ping":
        // Whole microseconds: times in ms with a fraction would lose some of them.
        return socket.send(JSON.stringify({ type: "pong", n: message["n"], received_us: Math.round(received * 1000), sent_us: Math.round(nowMs() * 1000) }));
      case "joined":
        this.#joined = true;
        this.#retryMs = FIRST_RETRY_MS;
        return this.tell({ type: "link", condition: "joined", words: `${String(message["camera"])} at ${String(message["site"])}` });
      case "report":
        return this.tell(message as unknown as Report);
    }
  }

  #lost(socket: WebSocket, reason: string, retries: boolean): void {
    if (socket !== this.#socket) return;
    this.close();
    this.tell({ type: "link", condition: retries ? (reason ? "refused" : "lost") : "ended", words: reason || "connection lost, retrying" });
    if (!retries) return;
    this.#timer = setTimeout(() => this.#open(), this.#retryMs * (0.8 + 0.4 * Math.random())) as unknown as number;
    this.#retryMs = Math.min(this.#retryMs * 1.6, LAST_RETRY_MS);
  }
}

function parsed(data: unknown): Record<string, unknown> | null {
  try {
    const message: unknown = JSON.parse(String(data));
    return typeof message === "object" && message !== null ? (message as Record<string, unknown>) : null;
  } catch {
    return null;
  }
}

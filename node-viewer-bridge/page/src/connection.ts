// The WebSocket to the bridge: keeps trying for ever, notices a connection that went silent, hands frames on.

import { type Message, type Preview, parseMessage, parsePreview } from "./protocol.ts";

export interface ConnectionEvents {
  message(message: Message): void;
  preview(preview: Preview): void;
  /** Only changes are told. */
  connected(up: boolean): void;
}

const FIRST_RETRY_MS = 400;
const LAST_RETRY_MS = 3000;
/** The bridge sends its status every second; this much silence means that the link is dead. */
const SILENCE_MS = 5000;
const CONNECT_TIMEOUT_MS = 5000;

export class Connection {
  private socket: WebSocket | null = null;
  private retryMs = FIRST_RETRY_MS;
  private watchdog = 0;
  private up: boolean | null = null;

  constructor(
    private readonly url: string,
    private readonly events: ConnectionEvents,
  ) {}

  open(): void {
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => this.take(event.data);
    socket.onclose = () => this.lost(socket);
    this.socket = socket;
    this.watch(CONNECT_TIMEOUT_MS);
  }

  private take(frame: string | ArrayBuffer): void {
    this.watch(SILENCE_MS);
    if (typeof frame !== "string") {
      const preview = parsePreview(frame);
      if (preview) this.events.preview(preview);
      return;
    }
    const message = parseMessage(frame);
    if (!message) return;
    if (message.type === "hello") {
      this.retryMs = FIRST_RETRY_MS;
      this.tell(true);
    }
    this.events.message(message);
  }

  private watch(ms: number): void {
    clearTimeout(this.watchdog);
    const socket = this.socket;
    if (socket) this.watchdog = window.setTimeout(() => this.lost(socket), ms);
  }

  private lost(socket: WebSocket): void {
    if (socket !== this.socket) return;
    clearTimeout(this.watchdog);
    this.socket = null;
    socket.onmessage = null;
    socket.close();
    this.tell(false);
    window.setTimeout(() => this.open(), this.retryMs * (0.8 + 0.4 * Math.random()));
    this.retryMs = Math.min(this.retryMs * 1.6, LAST_RETRY_MS);
  }

  private tell(up: boolean): void {
    if (up === this.up) return;
    this.up = up;
    this.events.connected(up);
  }
}

/** The bridge's WebSocket beside this page. */
export function socketUrl(page: Location, maxHz: number): string {
  const url = new URL("ws", page.href);
  url.protocol = page.protocol === "https:" ? "wss:" : "ws:";
  url.search = `?max_hz=${maxHz}`;
  url.hash = "";
  return url.href;
}

"""
Reads a site's messages from its viewer bridge, over its WebSocket.

    using Sextant
    connection = Sextant.connect("127.0.0.1", 8600)
    while true
        message = Sextant.receive(connection)
        if message["type"] == "pose"
            println(message["object"], " ", message["position"])
        end
    end

Messages are dictionaries with the fields that `node-viewer-bridge/PROTOCOL.md` lists: lengths in metres, quaternions
x, y, z, w, times in whole nanoseconds since 1970. Needs the package JSON.
"""
module Sextant

using JSON
using Sockets

const KEY = "dGhlIHNhbXBsZSBub25jZQ=="

"""
    connect(host, port = 8600; max_hz = 100, token = nothing)

Opens the stream: each object at most `max_hz` times a second, 1 to 1000, the newest pose each time. `token` is a
viewer's, for sites whose page asks for one. Pages that are served by TLS are out of reach. `close` ends the stream.

Throws an `ErrorException` with the answer where the bridge refuses.
"""
function connect(host::AbstractString, port::Integer = 8600; max_hz::Integer = 100, token = nothing)
    socket = Sockets.connect(host, port)
    lines = [
        "GET /ws?max_hz=$max_hz HTTP/1.1", "Host: $host:$port", "Upgrade: websocket", "Connection: Upgrade",
        "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: $KEY",
    ]
    token === nothing || push!(lines, "Authorization: Bearer $token")
    write(socket, join(lines, "\r\n") * "\r\n\r\n")
    status = readline(socket)
    if !startswith(status, "HTTP/1.1 101")
        close(socket)
        hint = startswith(status, "HTTP/1.1 401") ? ": this site wants a token" : ""
        error("the viewer bridge at $host:$port answers '$status'$hint")
    end
    while !isempty(readline(socket)) end
    return socket
end

"""
    receive(connection)

Waits for the next message. Throws an `EOFError` where the bridge is gone, an `ErrorException` with the reason where it
closed the stream.
"""
function receive(connection::IO)
    while true
        opcode = read(connection, UInt8) & 0x0f
        n = UInt64(read(connection, UInt8) & 0x7f)
        n == 126 && (n = UInt64(ntoh(read(connection, UInt16))))
        n == 127 && (n = ntoh(read(connection, UInt64)))
        payload = read(connection, n)
        length(payload) == n || throw(EOFError())
        opcode == 0x1 && return JSON.parse(String(payload))
        opcode == 0x8 && error("the viewer bridge closed the stream: $(String(payload[3:end]))")
        # A ping is answered with its content, masked by zeros; preview pictures (0x2) are passed over.
        opcode == 0x9 && write(connection, UInt8[0x8a, 0x80 | n, 0, 0, 0, 0], payload)
    end
end

end

function connection = connect(host, port, max_hz, token)
%CONNECT Open the stream of a site's messages at its viewer bridge.
%   CONNECTION = SEXTANT.CONNECT(HOST, PORT) connects to the bridge, at port
%   8600 where nobody chose another. SEXTANT.RECEIVE reads the messages, and
%   "clear connection" closes the stream.
%
%   SEXTANT.CONNECT(HOST, PORT, MAX_HZ) receives each object at most MAX_HZ
%   times a second, 1 to 1000 (default 100): the newest pose each time.
%
%   SEXTANT.CONNECT(HOST, PORT, MAX_HZ, TOKEN) is for sites with keys: TOKEN is
%   a viewer's, as the page asks for it. Pages that are served by TLS are out
%   of reach, since tcpclient has none: use the bridge on its own machine.
%
%   Needs MATLAB R2020b, or Octave 7 with its package instrument-control.

if nargin < 3
    max_hz = 100;
end
% A bridge that is there sends something each second.
connection = tcpclient(char(host), port, 'Timeout', 10);
crlf = char([13 10]);
request = [sprintf('GET /ws?max_hz=%d HTTP/1.1', max_hz), crlf, ...
    sprintf('Host: %s:%d', char(host), port), crlf, ...
    'Upgrade: websocket', crlf, 'Connection: Upgrade', crlf, ...
    'Sec-WebSocket-Version: 13', crlf, ...
    'Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==', crlf];
if nargin > 3
    request = [request, 'Authorization: Bearer ', char(token), crlf];
end
write(connection, uint8([request, crlf]));

answer = '';
while ~endsWith(answer, [crlf, crlf])
    byte = read(connection, 1, 'uint8');
    if isempty(byte) || numel(answer) > 8192
        error('sextant:connect', 'no viewer bridge answers at %s:%d', char(host), port);
    end
    answer(end + 1) = char(byte); %#ok<AGROW> A few hundred bytes.
end
if ~startsWith(answer, 'HTTP/1.1 101')
    status = strtok(answer, crlf);
    if startsWith(answer, 'HTTP/1.1 401')
        status = [status, ': this site wants a token, the fourth argument'];
    end
    error('sextant:connect', 'the viewer bridge at %s:%d answers %s', char(host), port, status);
end
end

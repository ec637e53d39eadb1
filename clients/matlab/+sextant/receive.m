function message = receive(connection)
%RECEIVE Wait for the next message of a site.
%   MESSAGE = SEXTANT.RECEIVE(CONNECTION) is a struct with the field "type" and
%   the fields of that type, as node-viewer-bridge/PROTOCOL.md lists them:
%
%       pose = sextant.receive(connection);
%       if strcmp(pose.type, 'pose')
%           disp(pose.object), disp(pose.position')
%       end
%
%   Lengths are in metres, quaternions x, y, z, w, matrices of 36 numbers are
%   read by reshape(pose.covariance, 6, 6). Times (t_ns, now_ns) are whole
%   nanoseconds since 1970 as uint64.
%
%   An error says why where the stream has ended.

message = [];
while isempty(message)
    header = bytes(connection, 2);
    opcode = bitand(header(1), 15);
    n = bitand(header(2), 127);
    if n == 126
        n = [256 1] * bytes(connection, 2)';
    elseif n == 127
        n = 256 .^ (7:-1:0) * bytes(connection, 8)';
    end
    payload = bytes(connection, n);
    switch opcode
        case 1
            text = native2unicode(uint8(payload), 'UTF-8');
            message = jsondecode(text);
            message = with_whole_times(message, text);
        case 8
            reason = char(payload(3:end));
            error('sextant:closed', 'the viewer bridge closed the stream: %s', reason);
        case 9
            % A pong with the same content, masked by zeros.
            write(connection, uint8([138, 128 + n, 0, 0, 0, 0, payload]));
    end
end
end

function data = bytes(connection, n)
% So many bytes as a row of double; an error where they do not come.
data = zeros(1, 0);
while numel(data) < n
    more = read(connection, n - numel(data), 'uint8');
    if isempty(more)
        error('sextant:closed', 'the viewer bridge sends nothing any more');
    end
    data = [data, double(more(:)')]; %#ok<AGROW> One piece as a rule.
end
end

function message = with_whole_times(message, text)
% jsondecode rounds to double, which is 256 ns for today's times.
for name = {'t_ns', 'now_ns'}
    found = regexp(text, ['"' name{1} '":(\d+)'], 'tokens', 'once');
    if ~isempty(found) && isfield(message, name{1})
        whole = uint64(0);
        for digit = found{1}
            whole = whole * 10 + uint64(digit - '0');
        end
        message.(name{1}) = whole;
    end
end
end

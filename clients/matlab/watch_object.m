%WATCH_OBJECT Print where an object is, for ten seconds, and draw its way.
%   Start "sextant demo" before. For another object or bridge set the variables
%   object, host, port or seconds first.

if ~exist('object', 'var'), object = 'cuboid'; end
if ~exist('host', 'var'), host = '127.0.0.1'; end
if ~exist('port', 'var'), port = 8600; end
if ~exist('seconds', 'var'), seconds = 10; end

connection = sextant.connect(host, port);
positions = zeros(0, 3);
start = tic;
while toc(start) < seconds
    message = sextant.receive(connection);
    if strcmp(message.type, 'pose') && strcmp(message.object, object)
        positions(end + 1, :) = message.position'; %#ok<SAGROW>
        sigmas = sqrt(diag(reshape(message.covariance, 6, 6)));
        fprintf('%s  %8.4f %8.4f %8.4f m  sigma %.2f mm  %s\n', object, ...
            message.position, 1e3 * norm(sigmas(1:3)), message.state);
    end
end
clear connection
plot3(positions(:, 1), positions(:, 2), positions(:, 3));
axis equal, grid on, xlabel('x (m)'), ylabel('y (m)'), zlabel('z (m)');

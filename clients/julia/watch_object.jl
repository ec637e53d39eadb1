# Prints where an object is, for ten seconds: julia watch_object.jl [OBJECT [HOST [PORT]]], with `sextant demo` running.

include(joinpath(@__DIR__, "Sextant.jl"))
using LinearAlgebra
using Printf

object = get(ARGS, 1, "cuboid")
connection = Sextant.connect(get(ARGS, 2, "127.0.0.1"), parse(Int, get(ARGS, 3, "8600")))
finish = time() + 10
while time() < finish
    message = Sextant.receive(connection)
    message["type"] == "pose" && message["object"] == object || continue
    x, y, z = message["position"]
    # Row-major and symmetric.
    covariance = reshape(Float64.(message["covariance"]), 6, 6)
    sigma_mm = 1e3 * sqrt(tr(covariance[1:3, 1:3]))
    @printf("%s  %8.4f %8.4f %8.4f m  sigma %.2f mm  %s\n", object, x, y, z, sigma_mm, message["state"])
end
close(connection)

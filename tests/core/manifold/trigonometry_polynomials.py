#!/usr/bin/python3
"""The polynomials of core/simd/trigonometry_body.inc and core/linear_algebra/logarithm.cpp, computed with 80 digits: interpolation at Chebyshev's
nodes, rounded to doubles, with the largest relative error that the function has by the rounded polynomial."""

from decimal import Decimal, getcontext

getcontext().prec = 80
PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")


def series(z, coefficient):
    """sum of coefficient(n) z^n until the terms vanish."""
    total, power, n = Decimal(0), Decimal(1), 0
    while n < 400:
        term = coefficient(n) * power
        total += term
        if n > 2 and abs(term) < Decimal("1e-75"):
            break
        power *= z
        n += 1
    return total


def factorial(n):
    product = Decimal(1)
    for i in range(2, n + 1):
        product *= i
    return product


def sine(z):  # (sin x - x)/x^3, z = x^2
    return series(z, lambda n: (-1) ** (n + 1) / factorial(2 * n + 3))


def cosine(z):  # (cos x - 1 + z/2)/z^2
    return series(z, lambda n: (-1) ** n / factorial(2 * n + 4))


def arc_tangent(z):  # (atan u - u)/u^3, z = u^2
    return series(z, lambda n: Decimal((-1) ** (n + 1)) / (2 * n + 3))


def logarithm(z):  # (log((1 + s)/(1 - s)) - 2 s)/s^3, z = s^2
    return series(z, lambda n: Decimal(2) / (2 * n + 3))


def cos_of(x):
    return 1 - x * x / 2 + (x * x) ** 2 * cosine(x * x)


def interpolate(f, end, count):
    """Coefficients, lowest power first, of the polynomial through `count` Chebyshev nodes of [0, end]."""
    nodes = []
    for i in range(count):
        # cos of (2 i + 1) pi / (2 count), by the double angle of a quarter of it
        c = cos_of((2 * i + 1) * PI / (8 * count))
        c = 2 * c * c - 1
        nodes.append(end / 2 * (1 + (2 * c * c - 1)))
    table = [f(z) for z in nodes]
    for level in range(1, count):
        for i in range(count - 1, level - 1, -1):
            table[i] = (table[i] - table[i - 1]) / (nodes[i] - nodes[i - level])
    coefficients = [Decimal(0)] * count
    for i in range(count - 1, -1, -1):  # Newton's form to powers
        for j in range(count - 1, 0, -1):
            coefficients[j] = coefficients[j - 1] - nodes[i] * coefficients[j]
        coefficients[0] = table[i] - nodes[i] * coefficients[0]
    return coefficients


def show(name, f, end, count, whole):
    rounded = [float(c) for c in interpolate(f, end, count)]
    worst = Decimal(0)
    for i in range(1, 401):
        z = end * i / 400
        got = sum(Decimal(c) * z**n for n, c in enumerate(rounded))
        worst = max(worst, abs((got - f(z)) * whole(z)))
    print(name, "relative error 2^%.1f" % (worst.ln() / Decimal(2).ln()))
    print(",\n".join(c.hex() for c in rounded))


show("sine", sine, (PI / 4) ** 2, 6, lambda z: z)
show("cosine", cosine, (PI / 4) ** 2, 6, lambda z: z * z)
show("arc tangent", arc_tangent, Decimal("0.25"), 13, lambda z: z)
show("logarithm", logarithm, Decimal("0.02944"), 7, lambda z: z / 2)


def parts(value, bits):
    """The value as doubles of so many bits each, and the last as it is."""
    out = []
    for b in bits:
        exponent = (value.ln() / Decimal(2).ln()).to_integral_value(rounding="ROUND_FLOOR")
        unit = Decimal(2) ** (int(exponent) - b + 1)
        part = (value / unit).to_integral_value(rounding="ROUND_FLOOR") * unit
        out.append(float(part))
        assert Decimal(out[-1]) == part
        value -= part
    return [x.hex() for x in out + [float(value)]]


print("pi/2", parts(PI / 2, [33, 33, 33]), "2/pi", float(2 / PI).hex())
print("pi/4", parts(PI / 4, [50]))
print("ln 2", parts(Decimal(2).ln(), [40]))

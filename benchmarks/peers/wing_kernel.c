/* Body and two prescribed wings in quasi-steady air by classical Runge-Kutta steps, written by hand.
 *
 * The equations of flycontrol.flight.kernels: blade elements with C_L and C_D as polynomials in sin(a - 45 deg),
 * rotational force, added mass in the mass matrix, dissipation, Newton and Euler for body and wings. WIDTH 1: one fly
 * in scalars. WIDTH w: `real` is a vector of w doubles, and LANES flies pass in LANES / w groups; the rest of the
 * source is the same. Arrays have the fly as their last index. Reciprocals and roots are the compiler's.
 */
#include <math.h>

#ifndef WIDTH
#define WIDTH 1
#endif
#ifndef LANES
#define LANES WIDTH
#endif
#define TERMS 9
#define INLINE static inline __attribute__((always_inline))

#if WIDTH == 1
typedef double real;
typedef long long bits;
INLINE real load(const double *p) { return *p; }
INLINE void store(double *p, real a) { *p = a; }
INLINE real root(real a) { return sqrt(a); }
INLINE real size(real a) { return fabs(a); }
INLINE real sign_of(real a, real b) { return copysign(a, b); }
INLINE real choose(bits m, real a, real b) { return m ? a : b; }
INLINE bits rounded(real a) { return (bits)(a + copysign(0.5, a)); }
INLINE real number(bits k) { return (real)k; }
#else
typedef double real __attribute__((vector_size(8 * WIDTH)));
typedef double unaligned __attribute__((vector_size(8 * WIDTH), aligned(8)));
typedef long long bits __attribute__((vector_size(8 * WIDTH)));
#define SIGN (1LL << 63)
INLINE real load(const double *p) { return *(const unaligned *)p; }
INLINE void store(double *p, real a) { *(unaligned *)p = a; }
INLINE real root(real a) { real b; for (int i = 0; i < WIDTH; i++) b[i] = sqrt(a[i]); return b; }
INLINE real size(real a) { return (real)((bits)a & ~SIGN); }
INLINE real sign_of(real a, real b) { return (real)(((bits)a & ~SIGN) | ((bits)b & SIGN)); }
INLINE real choose(bits m, real a, real b) { return (real)((m & (bits)a) | (~m & (bits)b)); }
INLINE bits rounded(real a) { return __builtin_convertvector(a + sign_of(0.5 + 0 * a, a), bits); }
INLINE real number(bits k) { return __builtin_convertvector(k, real); }
#endif

typedef struct { real x, y, z; } vec;
typedef struct { real xx, xy, xz, yy, yz, zz; } sym;
typedef struct { vec a, b, c; } rows;

INLINE vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
INLINE vec sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
INLINE vec mul(real k, vec a) { return (vec){k * a.x, k * a.y, k * a.z}; }
INLINE real dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
INLINE vec cross(vec a, vec b) {
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
INLINE vec times(rows m, vec a) { return (vec){dot(m.a, a), dot(m.b, a), dot(m.c, a)}; }
INLINE vec along(rows m, vec a) { return add(add(mul(a.x, m.a), mul(a.y, m.b)), mul(a.z, m.c)); }
INLINE vec by(sym m, vec a) {
    return (vec){m.xx * a.x + m.xy * a.y + m.xz * a.z, m.xy * a.x + m.yy * a.y + m.yz * a.z,
                 m.xz * a.x + m.yz * a.y + m.zz * a.z};
}
INLINE sym inverse(sym m) {
    real a = m.yy * m.zz - m.yz * m.yz, b = m.xz * m.yz - m.xy * m.zz, c = m.xy * m.yz - m.xz * m.yy;
    real k = 1.0 / (m.xx * a + m.xy * b + m.xz * c);
    return (sym){k * a, k * b, k * c, k * (m.xx * m.zz - m.xz * m.xz), k * (m.xy * m.xz - m.xx * m.yz),
                 k * (m.xx * m.yy - m.xy * m.xy)};
}
/* polar vectors and axial vectors in the mirror y = 0 of the left wing, side -1 */
INLINE vec polar(vec a, double side) { return (vec){a.x, side * a.y, a.z}; }
INLINE vec axial(vec a, double side) { return (vec){side * a.x, a.y, side * a.z}; }

INLINE void sine_cosine(real x, real *sine, real *cosine) {
    bits k = rounded(x * 0.63661977236758134308);
    real f = number(k), r = (x - f * 1.5707963267341256) - f * 6.077100506506192e-11, z = r * r;
    real s = 1.58962301576546568060e-10 * z - 2.50507477628578072866e-8;
    s = s * z + 2.75573136213857245213e-6;
    s = s * z - 1.98412698295895385996e-4;
    s = s * z + 8.33333333332211858878e-3;
    s = r + r * z * (s * z - 1.66666666666666307295e-1);
    real c = -1.13585365213876817300e-11 * z + 2.08757008419747316778e-9;
    c = c * z - 2.75573141792967388112e-7;
    c = c * z + 2.48015872888517045348e-5;
    c = c * z - 1.38888888888730564116e-3;
    c = 1.0 - 0.5 * z + z * z * (c * z + 4.16666666666665929218e-2);
    bits odd = (k & 1) != 0;
    real one = choose(odd, c, s), other = choose(odd, s, c);
    *sine = choose((k & 2) != 0, -one, one);
    *cosine = choose(((k + 1) & 2) != 0, -other, other);
}

typedef struct { vec p; real q0, q1, q2, q3; vec v, w; } state;

INLINE vec world(real q0, real q1, real q2, real q3, vec a) {
    vec u = {q1, q2, q3}, t = mul(2.0 + 0 * q0, cross(u, a));
    return add(add(a, mul(q0, t)), cross(u, t));
}

/* what one wing, as a right wing, adds to the equations of the body */
INLINE void wing(vec v_h, vec o, vec gravity, vec h, const double *drive, const double *constants,
                 const double *blades, long nodes, const double (*poly)[TERMS], sym *Maa, rows *Maw, sym *Mww, vec *F,
                 vec *N) {
#define C(k) load(constants + (k) * LANES)
#define D(k) load(drive + (k) * LANES)
    real sp, cp, st, ct, se, ce;
    sine_cosine(D(0), &sp, &cp);
    sine_cosine(D(1), &st, &ct);
    sine_cosine(D(2), &se, &ce);
    vec up = {-sp * st, -cp * st, -ct};
    rows axes = {{sp * ct, cp * ct, -st},
                 {ce * cp + se * up.x, -ce * sp + se * up.y, se * up.z},
                 {ce * up.x - se * cp, ce * up.y + se * sp, ce * up.z}};
    real phi = D(3), theta = D(4), eta = D(5), ddphi = D(6), ddtheta = D(7), ddeta = D(8);
    vec js = {st, se * ct, ce * ct};
    vec rel = {js.x * phi + eta, js.y * phi - ce * theta, js.z * phi + se * theta};
    vec bias = {phi * theta * ct, phi * (js.z * eta - se * st * theta) + theta * se * eta,
                phi * (-js.y * eta - ce * st * theta) + theta * ce * eta};
    vec u = times(axes, v_h), ow = times(axes, o), w = add(ow, rel);
    vec drel = {js.x * ddphi + ddeta, js.y * ddphi - ce * ddtheta, js.z * ddphi + se * ddtheta};
    vec dw = sub(add(bias, drel), cross(rel, ow)), a = sub(cross(ow, u), times(axes, gravity));
    real du = u.x * rel.y - u.y * rel.x;

    real m = C(0), s = C(1), c = C(2), iss = C(3), icc = C(4), inn = C(5), isc = C(6);
    real a_nn = C(7), a_ns = C(8), a_nc = C(9), a_ss = C(10), a_sc = C(11), a_cc = C(12);
    real lever = w.x * s + w.y * c, square = dot(w, w);
    vec f = {m * (a.x - dw.z * c + w.x * lever - square * s), m * (a.y + dw.z * s + w.y * lever - square * c),
             m * (a.z + dw.x * c - dw.y * s + w.z * lever)};
    vec turn = cross(w, (vec){iss * w.x + isc * w.y, isc * w.x + icc * w.y, inn * w.z});
    vec n = {iss * dw.x + isc * dw.y + turn.x + m * c * a.z, isc * dw.x + icc * dw.y + turn.y - m * s * a.z,
             inn * dw.z + turn.z + m * (s * a.y - c * a.x)};
    real P = a_nn * u.z + a_ns * w.x + a_nc * w.y, Lc = a_nc * u.z + a_sc * w.x + a_cc * w.y;
    f.y -= w.x * P;
    f.z += a_nn * du + a_ns * dw.x + a_nc * dw.y;
    n.x += a_ns * du + a_ss * dw.x + a_sc * dw.y + (C(13) + C(14) * size(w.x)) * w.x;
    n.y += a_nc * du + a_sc * dw.x + a_cc * dw.y;
    n.z += w.x * Lc;

    real ahead = C(15), quarter = C(16), zero = 0 * m;
    real tc = zero, tn = zero, ts = zero, tcr = zero, tnr = zero, arms = zero;
    for (long j = 0; j < nodes; j++) {
        const double *b = blades + 4 * j * LANES;
        real r = load(b), uc = u.y + r * w.z, un = u.z - r * w.y, speed = root(uc * uc + un * un + 1e-40);
        real z = 0.70710678118654752440 * (size(un) - size(uc)) / speed, z2 = z * z;
        real le = poly[0][TERMS - 1] + zero, lo = poly[1][TERMS - 1] + zero, de = poly[2][TERMS - 1] + zero;
        real od = poly[3][TERMS - 1] + zero, ct_ = poly[4][TERMS - 1] + zero;
        for (int k = TERMS - 2; k >= 0; k--) {
            le = le * z2 + poly[0][k];
            lo = lo * z2 + poly[1][k];
            de = de * z2 + poly[2][k];
            od = od * z2 + poly[3][k];
            ct_ = ct_ * z2 + poly[4][k];
        }
        real lift = sign_of(le + z * lo, uc * un);
        real drag = de + z * od, arm = ahead + sign_of(quarter - z * ct_, uc);
        real pc = speed * (lift * un - drag * uc), pn = -speed * (drag * un + lift * uc), pressure = load(b + LANES);
        ts += load(b + 2 * LANES) * arm * pn;
        pc *= pressure;
        pn *= pressure;
        tc += pc;
        tn += pn;
        tcr += r * pc;
        tnr += r * pn;
        arms += load(b + 3 * LANES) * arm * uc;
    }
    real g0 = C(17) * w.x, g1 = C(18) * w.x, g2 = C(19) * w.x;
    f.y -= tc - (g0 * u.z - g1 * w.y);
    f.z -= tn + g0 * u.y + g1 * w.z;
    n.x -= ts + w.x * arms;
    n.y += tnr + g1 * u.y + g2 * w.z;
    n.z -= tcr - (g1 * u.z - g2 * w.y);

    vec fS = along(axes, f);
    *F = fS;
    *N = add(along(axes, n), cross(h, fS));

    vec span = axes.a, chord = axes.b, normal = axes.c;
    real bsn = -m * c, bcn = m * s, bns = m * c + a_ns, bnc = -m * s + a_nc;
    real kss = iss + a_ss, ksc = isc + a_sc, kcc = icc + a_cc;
    vec d = add(mul(bsn, span), mul(bcn, chord)), e = add(mul(bns, span), mul(bnc, chord));
    vec l = cross(h, normal), hd = cross(h, d), to = add(e, mul(a_nn, l)), mh = mul(m, h), q = normal;
    *Maa = (sym){a_nn * q.x * q.x + m, a_nn * q.x * q.y, a_nn * q.x * q.z, a_nn * q.y * q.y + m, a_nn * q.y * q.z,
                 a_nn * q.z * q.z + m};
    *Maw = (rows){{d.x * q.x + q.x * to.x, d.x * q.y + q.x * to.y + mh.z, d.x * q.z + q.x * to.z - mh.y},
                  {d.y * q.x + q.y * to.x - mh.z, d.y * q.y + q.y * to.y, d.y * q.z + q.y * to.z + mh.x},
                  {d.z * q.x + q.z * to.x + mh.y, d.z * q.y + q.z * to.y - mh.x, d.z * q.z + q.z * to.z}};
    real far = m * dot(h, h);
    vec ks = add(mul(kss, span), mul(2.0 * ksc, chord)), kc = mul(kcc, chord), kn = mul(inn, normal);
    vec al = mul(a_nn, l), em = add(e, e);
#define M(i, j)                                                                                                      \
    (0.5 * (ks.i * span.j + ks.j * span.i + em.i * l.j + em.j * l.i) + kc.i * chord.j + kn.i * normal.j +             \
     q.i * hd.j + q.j * hd.i + al.i * l.j - mh.i * h.j)
    *Mww = (sym){M(x, x) + far, M(x, y), M(x, z), M(y, y) + far, M(y, z), M(z, z) + far};
}

INLINE void rates(const state *y, const double *drive, const double *outside, const double *gravity,
                  const double *body, const double *wings, const double *blades, long nodes,
                  const double (*poly)[TERMS], state *rate) {
#define B(k) load(body + (k) * LANES)
#define O(k) load(outside + (k) * LANES)
    vec v = y->v, w = y->w, h = {B(7), B(8), B(9)};
    real zero = 0 * v.x, m = B(0);
    vec G = {gravity[0] + zero, gravity[1] + zero, gravity[2] + zero};
    vec g = world(y->q0, -y->q1, -y->q2, -y->q3, G);
    sym I = {B(1), B(2), B(3), B(4), B(5), B(6)}, aa = {m, zero, zero, m, zero, m}, ww = I;
    rows aw = {{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero}};
    vec f = sub((vec){O(0), O(1), O(2)}, mul(m, sub(cross(w, v), g)));
    vec n = sub((vec){O(3), O(4), O(5)}, cross(w, by(I, w)));
#pragma GCC unroll 1
    for (int k = 0; k < 2; k++) {
        double t = 2.0 * k - 1.0;
        vec vm = polar(v, t), wm = axial(w, t), F, N;
        sym Maa, Mww;
        rows Maw;
        wing(add(vm, cross(wm, h)), wm, polar(g, t), h, drive + 9 * k * LANES, wings + 20 * k * LANES,
             blades + 4 * k * nodes * LANES, nodes, poly, &Maa, &Maw, &Mww, &F, &N);
        aa = (sym){aa.xx + Maa.xx, aa.xy + t * Maa.xy, aa.xz + Maa.xz, aa.yy + Maa.yy, aa.yz + t * Maa.yz,
                   aa.zz + Maa.zz};
        ww = (sym){ww.xx + Mww.xx, ww.xy + t * Mww.xy, ww.xz + Mww.xz, ww.yy + Mww.yy, ww.yz + t * Mww.yz,
                   ww.zz + Mww.zz};
        aw = (rows){{aw.a.x + t * Maw.a.x, aw.a.y + Maw.a.y, aw.a.z + t * Maw.a.z},
                    {aw.b.x + Maw.b.x, aw.b.y + t * Maw.b.y, aw.b.z + Maw.b.z},
                    {aw.c.x + t * Maw.c.x, aw.c.y + Maw.c.y, aw.c.z + t * Maw.c.z}};
        f = sub(f, polar(F, t));
        n = sub(n, axial(N, t));
    }
    sym E = inverse(aa);
    vec c0 = by(E, (vec){aw.a.x, aw.b.x, aw.c.x}), c1 = by(E, (vec){aw.a.y, aw.b.y, aw.c.y});
    vec c2 = by(E, (vec){aw.a.z, aw.b.z, aw.c.z});
    vec m0 = along(aw, c0), m1 = along(aw, c1), m2 = along(aw, c2);
    sym schur = {ww.xx - m0.x, ww.xy - m0.y, ww.xz - m0.z, ww.yy - m1.y, ww.yz - m1.z, ww.zz - m2.z};
    rate->w = by(inverse(schur), sub(n, (vec){dot(c0, f), dot(c1, f), dot(c2, f)}));
    rate->v = sub(by(E, f), along((rows){c0, c1, c2}, rate->w));
    rate->p = world(y->q0, y->q1, y->q2, y->q3, v);
    rate->q0 = 0.5 * (-y->q1 * w.x - y->q2 * w.y - y->q3 * w.z);
    rate->q1 = 0.5 * (y->q0 * w.x + y->q2 * w.z - y->q3 * w.y);
    rate->q2 = 0.5 * (y->q0 * w.y + y->q3 * w.x - y->q1 * w.z);
    rate->q3 = 0.5 * (y->q0 * w.z + y->q1 * w.y - y->q2 * w.x);
}

#define EACH(op)                                                                                                     \
    for (int i = 0; i < 13; i++) op
#define AS_ROWS(s) ((real *)(s))

/* y (13, LANES), drive (2 n + 1, 18, LANES), step (LANES), outside (n, 6, LANES), gravity (3), body (10, LANES), wings
 * (2, 20, LANES), blades (2, nodes, 4, LANES), poly (5, 9), samples (n / stride, 19, LANES): states, v', w' */
void march(double *y, const double *drive, const double *step, const double *outside, long steps, long stride,
           const double *gravity, const double *body, const double *wings, const double *blades, long nodes,
           const double *poly, double *samples) {
    for (long lane = 0; lane < LANES; lane += WIDTH) {
        state now, at, end, rate;
        EACH(AS_ROWS(&now)[i] = load(y + i * LANES + lane));
        real h = load(step + lane);
        for (long k = 0; k < steps; k++) {
            at = end = now;
#pragma GCC unroll 1
            for (int stage = 0; stage < 4; stage++) {
                rates(&at, drive + (2 * k + (stage + 1) / 2) * 18 * LANES + lane, outside + k * 6 * LANES + lane,
                      gravity, body + lane, wings + lane, blades + lane, nodes, (const double(*)[TERMS])poly, &rate);
                if (stage == 0 && k % stride == 0) {
                    double *sample = samples + k / stride * 19 * LANES + lane;
                    EACH(store(sample + i * LANES, AS_ROWS(&now)[i]));
                    for (int i = 0; i < 6; i++) store(sample + (13 + i) * LANES, AS_ROWS(&rate)[7 + i]);
                }
                real part = h * (stage == 2 ? 1.0 : 0.5), share = h * (stage == 1 || stage == 2 ? 1.0 / 3 : 1.0 / 6);
                EACH(AS_ROWS(&at)[i] = AS_ROWS(&now)[i] + part * AS_ROWS(&rate)[i]);
                EACH(AS_ROWS(&end)[i] += share * AS_ROWS(&rate)[i]);
            }
            real shrink = 1.0 / root(end.q0 * end.q0 + end.q1 * end.q1 + end.q2 * end.q2 + end.q3 * end.q3);
            end.q0 *= shrink, end.q1 *= shrink, end.q2 *= shrink, end.q3 *= shrink;
            now = end;
        }
        EACH(store(y + i * LANES + lane, AS_ROWS(&now)[i]));
    }
}

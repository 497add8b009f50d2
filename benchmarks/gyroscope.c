/* The two-mode gyroscope with gap-closing drive: Runge-Kutta 4 of steps that divide the tick, sources held over it.
   With SAME_OPERATIONS it does those of the graph, in their order, and is given what the sources are: drive[n] in V,
   rotation[n] in rad/s. Without, the force is written as equation 8 of Sarraf et al. 2012 has it, and the sources are
   computed here. record: n displacements of the sense mode. */
#include <math.h>
#include <stdint.h>

static inline double force(double v, double x)
{
    const double bias = 15.0, capacitance = 0.05e-12, gap = 4e-6;
#ifdef SAME_OPERATIONS
    double near = gap - x, far = gap + x, half = 0.5 * capacitance * gap;
    double pull = (bias + v) * far, pull_back = (bias - v) * near, both = near * far;
    return half * (pull * pull - pull_back * pull_back) / (both * both);
#else
    double near = (bias + v) / (1.0 - x / gap), far = (bias - v) / (1.0 + x / gap);
    return 0.5 * capacitance / gap * (near * near - far * far);
#endif
}

static inline void rates(double v, double turn, const double *x, double *r)
{
    const double m = 48.67e-9;
    double on_sense = -(2.0 * m * turn * x[1]), coriolis = 2.0 * m * turn * x[3];
    double on_drive = force(v, x[0]) + coriolis;
    r[0] = x[1];
#ifdef SAME_OPERATIONS
    r[1] = (on_drive - (18.9e-6 * x[1] + 122.28 * x[0])) / m;
    r[3] = (on_sense - (57e-6 * x[3] + 132.23 * x[2])) / m;
#else
    r[1] = (on_drive - 18.9e-6 * x[1] - 122.28 * x[0]) / m;
    r[3] = (on_sense - 57e-6 * x[3] - 132.23 * x[2]) / m;
#endif
    r[2] = x[3];
}

void gyroscope(int64_t n, int64_t substeps, double period, const double *drive, const double *rotation, double *record)
{
    const double pi = 3.14159265358979323846;
    double x[4] = {0.0, 0.0, 0.0, 0.0}, y[4], a[4], b[4], c[4], d[4], h = period / substeps;
    for (int64_t i = 0; i < n; i++) {
        record[i] = x[2];
#ifdef SAME_OPERATIONS
        double v = drive[i], turn = rotation[i];
#else
        double v = sin(2.0 * pi * 7963.0 * (double)i * period);
        double turn = 60.0 * pi / 180.0 * sin(2.0 * pi * 20.0 * (double)i * period);
#endif
        for (int64_t s = 0; s < substeps; s++) {
            rates(v, turn, x, a);
            for (int j = 0; j < 4; j++) y[j] = x[j] + h * (0.5 * a[j]);
            rates(v, turn, y, b);
            for (int j = 0; j < 4; j++) y[j] = x[j] + h * (0.5 * b[j]);
            rates(v, turn, y, c);
            for (int j = 0; j < 4; j++) y[j] = x[j] + h * c[j];
            rates(v, turn, y, d);
            for (int j = 0; j < 4; j++)
                x[j] = x[j] + h * (1.0 / 6.0 * a[j] + 1.0 / 3.0 * b[j] + 1.0 / 3.0 * c[j] + 1.0 / 6.0 * d[j]);
        }
    }
}

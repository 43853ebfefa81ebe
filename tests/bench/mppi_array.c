/* MPPI as published: noisy controls over flat arrays, rolled out, judged, averaged, smoothed.
 *
 * The peer of `python -m bringup bench controller`, which compiles it; no part of the product.
 * Written from the algorithm's description: G. Williams and others, Aggressive driving with model
 * predictive path integral control, ICRA 2016; A. Savitzky and M. Golay, Smoothing and
 * differentiation of data, 1964; the critics from the pages of nav2_mppi_controller, with their
 * default weights, for a circular robot. Arrays are `steps x batch`, so that loops run along the batch.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 4096, HISTORY = 4, LETHAL = 254, INSCRIBED = 253, UNKNOWN = 255 };
static const float PI = 3.14159265f, DT = 0.05f, PRUNE = 1.5f, SEARCH = 2.5f;
static const float TEMPERATURE = 0.3f, GAMMA = 0.015f, STD_V = 0.2f, STD_W = 0.4f, COLLISION = 1e6f;
static const float SMOOTH[9] = {-21, 14, 39, 54, 59, 54, 39, 14, -21};

typedef struct {
    float v_min, v_max, w_max, accel, accel_w, keep;
} Limits;

typedef struct {
    const uint8_t *data;
    int width, height;
    double resolution, x, y;
} Grid;

typedef struct {
    int batch, steps, count, first, furthest;
    Limits limits;
    float *noise[2], *control[2], *speed[2], *x, *y, *yaw, *cost, *sum, *share, *near;
    int *index;
    bool *hit;
    float *sequence[2], *fresh, history[2][HISTORY];
    float px[MOST], py[MOST], pyaw[MOST], along[MOST];
    bool free[MOST];
} Mppi;

void mppi_free(Mppi *m)
{
    for (int k = 0; k < 2; k++)
        free(m->noise[k]), free(m->control[k]), free(m->speed[k]), free(m->sequence[k]);
    free(m->x), free(m->y), free(m->yaw), free(m->cost), free(m->sum), free(m->share);
    free(m->near), free(m->index), free(m->hit), free(m->fresh), free(m);
}

/* Make the arrays; the noise is `2 x steps x batch`, of the speeds, then of the yaw rates. */
Mppi *mppi_make(int batch, int steps, const float *noise, Limits limits)
{
    Mppi *m = calloc(1, sizeof *m);
    size_t n = (size_t)batch * steps;
    m->batch = batch, m->steps = steps, m->limits = limits;
    for (int k = 0; k < 2; k++) {
        m->noise[k] = malloc(4 * n), m->control[k] = malloc(4 * n), m->speed[k] = malloc(4 * n);
        m->sequence[k] = calloc(steps, 4);
        memcpy(m->noise[k], noise + k * n, 4 * n);
    }
    m->x = malloc(4 * n), m->y = malloc(4 * n), m->yaw = malloc(4 * n);
    m->cost = malloc(4 * batch), m->sum = malloc(4 * batch), m->share = malloc(4 * batch);
    m->near = malloc(4 * batch), m->index = malloc(4 * batch), m->hit = malloc(batch);
    m->fresh = malloc(4 * steps);
    return m;
}

/* Look for the robot from the beginning of another path on. */
void mppi_restart(Mppi *m)
{
    m->first = 0;
}

/* Take the part of a path that counts, `poses x 3`, as the robot sees it. */
static void see_path(Mppi *m, const double *path, int poses, const double *robot, const Grid *g)
{
    double best = INFINITY, gone = 0.0;
    for (int i = m->first; i < poses && gone <= SEARCH; i++) {
        double gap = hypot(path[3 * i] - robot[0], path[3 * i + 1] - robot[1]);
        if (gap < best)
            best = gap, m->first = i;
        if (i + 1 < poses)
            gone += hypot(path[3 * i + 3] - path[3 * i], path[3 * i + 4] - path[3 * i + 1]);
    }
    double c = cos(robot[2]), s = sin(robot[2]);
    m->count = 0, gone = 0.0;
    for (int i = m->first; i < poses && m->count < MOST; i++) {
        const double *p = path + 3 * i;
        if (i > m->first)
            gone += hypot(p[0] - p[-3], p[1] - p[-2]);
        if (gone > PRUNE && m->count >= 2)
            break;
        int n = m->count++, column = (int)((p[0] - g->x) / g->resolution);
        int row = (int)((p[1] - g->y) / g->resolution);
        m->px[n] = c * (p[0] - robot[0]) + s * (p[1] - robot[1]);
        m->py[n] = c * (p[1] - robot[1]) - s * (p[0] - robot[0]);
        m->pyaw[n] = p[2] - robot[2], m->along[n] = gone;
        m->free[n] = row >= 0 && row < g->height && column >= 0 && column < g->width;
        int cost = m->free[n] ? g->data[row * g->width + column] : LETHAL;
        m->free[n] = cost < INSCRIBED || cost == UNKNOWN;
    }
}

static void roll_out(Mppi *m, float v0, float w0)
{
    const Limits l = m->limits;
    const int batch = m->batch;
    for (int k = 0; k < 2; k++) {
        const float low = k ? -l.w_max : l.v_min, high = k ? l.w_max : l.v_max;
        const float change = DT * (k ? l.accel_w : l.accel), now = k ? w0 : v0;
        for (int t = 0; t < m->steps; t++) {
            float *control = m->control[k] + t * batch, *speed = m->speed[k] + t * batch;
            const float *noise = m->noise[k] + t * batch, mean = m->sequence[k][t];
            for (int b = 0; b < batch; b++)
                control[b] = mean + noise[b];
            if (!t)
                for (int b = 0; b < batch; b++)
                    speed[b] = now;
            else
                for (int b = 0; b < batch; b++) {
                    float last = speed[b - batch], wish = fminf(fmaxf(control[b - batch], low), high);
                    speed[b] = fminf(fmaxf(wish, last - change), last + change);
                }
        }
    }
    for (int t = 0; t < m->steps; t++) {
        const float *v = m->speed[0] + t * batch, *w = m->speed[1] + t * batch;
        float *x = m->x + t * batch, *y = m->y + t * batch, *yaw = m->yaw + t * batch;
        if (!t)
            for (int b = 0; b < batch; b++)
                x[b] = v[b] * DT, y[b] = 0.0f, yaw[b] = w[b] * DT;
        else
            for (int b = 0; b < batch; b++) {
                float before = yaw[b - batch];
                x[b] = x[b - batch] + v[b] * DT * cosf(before);
                y[b] = y[b - batch] + v[b] * DT * sinf(before);
                yaw[b] = before + w[b] * DT;
            }
    }
}

/* Find the farthest pose of the path that is nearest to some rollout's end. */
static void find_furthest(Mppi *m)
{
    const float *x = m->x + (m->steps - 1) * m->batch, *y = m->y + (m->steps - 1) * m->batch;
    for (int b = 0; b < m->batch; b++)
        m->near[b] = INFINITY, m->index[b] = 0;
    for (int i = 0; i < m->count; i++)
        for (int b = 0; b < m->batch; b++) {
            float dx = x[b] - m->px[i], dy = y[b] - m->py[i], gap = dx * dx + dy * dy;
            m->index[b] = gap < m->near[b] ? i : m->index[b];
            m->near[b] = fminf(gap, m->near[b]);
        }
    m->furthest = 0;
    for (int b = 0; b < m->batch; b++)
        m->furthest = m->index[b] > m->furthest ? m->index[b] : m->furthest;
}

/* ConstraintCritic and PreferForwardCritic. */
static void judge_speeds(Mppi *m, float distance)
{
    const Limits l = m->limits;
    const float forward = distance >= 0.5f ? 5.0f : 0.0f;
    for (int t = 0; t < m->steps; t++) {
        const float *v = m->speed[0] + t * m->batch;
        for (int b = 0; b < m->batch; b++) {
            float beyond = fmaxf(l.v_min - v[b], 0.0f) + fmaxf(v[b] - l.v_max, 0.0f);
            m->cost[b] += DT * (4.0f * beyond + forward * fmaxf(-v[b], 0.0f));
        }
    }
}

/* CostCritic; return whether all collide. */
static bool judge_costs(Mppi *m, float distance, const double *robot, const Grid *g)
{
    const float scale = 1.0 / g->resolution;
    const float c = cos(robot[2]) * scale, s = sin(robot[2]) * scale;
    const float x0 = (robot[0] - g->x) * scale, y0 = (robot[1] - g->y) * scale;
    int looks = 0, hits = 0;
    memset(m->sum, 0, 4 * m->batch), memset(m->hit, 0, m->batch);
    for (int t = 0; t < m->steps; t += 2, looks++) {
        const float *x = m->x + t * m->batch, *y = m->y + t * m->batch;
        for (int b = 0; b < m->batch; b++) {
            int column = (int)(x0 + c * x[b] - s * y[b]), row = (int)(y0 + s * x[b] + c * y[b]);
            if (row < 0 || row >= g->height || column < 0 || column >= g->width) {
                m->hit[b] = true;
                continue;
            }
            int cost = g->data[row * g->width + column];
            if (cost >= INSCRIBED && cost != UNKNOWN)
                m->hit[b] = true;
            else if (cost != UNKNOWN && distance > 0.5f)
                m->sum[b] += cost;
        }
    }
    for (int b = 0; b < m->batch; b++) {
        m->cost[b] += 3.81f / LETHAL / looks * (m->hit[b] ? COLLISION : m->sum[b]);
        hits += m->hit[b];
    }
    return hits == m->batch;
}

/* GoalCritic and GoalAngleCritic, near a goal that the robot sees so. */
static void judge_goal(Mppi *m, float distance, float gx, float gy, float gyaw)
{
    const float part = 1.0f / m->steps;
    for (int t = 0; t < m->steps; t++) {
        const float *x = m->x + t * m->batch, *y = m->y + t * m->batch, *yaw = m->yaw + t * m->batch;
        if (distance <= 1.4f)
            for (int b = 0; b < m->batch; b++)
                m->cost[b] += 5.0f * part * sqrtf((x[b] - gx) * (x[b] - gx) + (y[b] - gy) * (y[b] - gy));
        if (distance <= 0.5f)
            for (int b = 0; b < m->batch; b++) {
                float turns = (yaw[b] - gyaw) / (2.0f * PI);
                m->cost[b] += 3.0f * part * 2.0f * PI * fabsf(turns - floorf(turns + 0.5f));
            }
    }
}

/* PathAlignCritic: how far from the pose that is as far along as the rollout has come. */
static void judge_alignment(Mppi *m)
{
    int blocked = 0;
    for (int i = 0; i <= m->furthest; i++)
        blocked += !m->free[i];
    if (m->furthest < 20 || blocked > 0.07f * (m->furthest + 1))
        return;
    memset(m->sum, 0, 4 * m->batch), memset(m->near, 0, 4 * m->batch);
    memset(m->share, 0, 4 * m->batch), memset(m->index, 0, 4 * m->batch);
    float *gone = m->near, *looks = m->share;
    for (int t = 4; t < m->steps; t += 4) {
        const float *x = m->x + t * m->batch, *y = m->y + t * m->batch, *u = x - 4 * m->batch;
        const float *w = y - 4 * m->batch;
        for (int b = 0; b < m->batch; b++)
            gone[b] += sqrtf((x[b] - u[b]) * (x[b] - u[b]) + (y[b] - w[b]) * (y[b] - w[b]));
        for (int b = 0; b < m->batch; b++) {
            int i = m->index[b];
            while (i < m->count - 1 && m->along[i + 1] <= gone[b])
                i++;
            m->index[b] = i;
            if (i < m->count - 1 && m->along[i + 1] - gone[b] < gone[b] - m->along[i])
                i++;
            if (!m->free[i])
                continue;
            float dx = x[b] - m->px[i], dy = y[b] - m->py[i];
            m->sum[b] += sqrtf(dx * dx + dy * dy), looks[b] += 1.0f;
        }
    }
    for (int b = 0; b < m->batch; b++)
        m->cost[b] += 10.0f * m->sum[b] / fmaxf(looks[b], 1.0f);
}

static int ahead(const Mppi *m, int offset)
{
    return m->furthest + offset < m->count ? m->furthest + offset : m->count - 1;
}

/* PathFollowCritic: how far the rollouts' ends are from a pose ahead. */
static void judge_progress(Mppi *m)
{
    const int row = (m->steps - 1) * m->batch;
    const float *x = m->x + row, *y = m->y + row;
    int i = ahead(m, 6);
    while (i < m->count - 1 && !m->free[i])
        i++;
    for (int b = 0; b < m->batch; b++) {
        float dx = x[b] - m->px[i], dy = y[b] - m->py[i];
        m->cost[b] += 5.0f * sqrtf(dx * dx + dy * dy);
    }
}

/* PathAngleCritic: how far the rollouts' ends look off a pose ahead. */
static void judge_angle(Mppi *m)
{
    const int row = (m->steps - 1) * m->batch, i = ahead(m, 4);
    const float *x = m->x + row, *y = m->y + row, *yaw = m->yaw + row;
    if (fabsf(atan2f(m->py[i], m->px[i])) < 0.785398f)
        return;
    for (int b = 0; b < m->batch; b++) {
        float turns = (atan2f(m->py[i] - y[b], m->px[i] - x[b]) - yaw[b]) / (2.0f * PI);
        m->cost[b] += 2.2f * 2.0f * PI * fabsf(turns - floorf(turns + 0.5f));
    }
}

/* Average the controls by their costs, and smooth the sequence. */
static void update(Mppi *m)
{
    const float gamma = GAMMA * (1.0f - m->limits.keep) / (1.0f + m->limits.keep);
    float least = INFINITY, total = 0.0f;
    for (int k = 0; k < 2; k++)
        for (int t = 0; t < m->steps; t++) {
            const float *control = m->control[k] + t * m->batch, mean = m->sequence[k][t];
            const float factor = gamma / (k ? STD_W * STD_W : STD_V * STD_V) * mean;
            for (int b = 0; b < m->batch; b++)
                m->cost[b] += factor * (control[b] - mean);
        }
    for (int b = 0; b < m->batch; b++)
        least = fminf(least, m->cost[b]);
    for (int b = 0; b < m->batch; b++)
        m->share[b] = expf((least - m->cost[b]) / TEMPERATURE), total += m->share[b];
    for (int k = 0; k < 2; k++) {
        const float low = k ? -m->limits.w_max : m->limits.v_min;
        const float high = k ? m->limits.w_max : m->limits.v_max;
        float *sequence = m->sequence[k], *fresh = m->fresh;
        for (int t = 0; t < m->steps; t++) {
            const float *control = m->control[k] + t * m->batch;
            float mean = 0.0f;
            for (int b = 0; b < m->batch; b++)
                mean += m->share[b] * control[b];
            fresh[t] = mean / total;
        }
        for (int t = 0; t < m->steps; t++) {
            float sum = 0.0f;
            for (int i = 0; i < 9; i++) {
                int j = t + i - HISTORY;
                j = j < m->steps ? j : m->steps - 1;
                sum += SMOOTH[i] / 231.0f * (j < 0 ? m->history[k][j + HISTORY] : fresh[j]);
            }
            sequence[t] = fminf(fmaxf(sum, low), high);
        }
    }
}

/* Write the command `v, w` of a robot at a pose that drives so; return false where all collide. */
bool mppi_command(Mppi *m, const double *path, int poses, const double *robot, float v, float w,
                  Grid grid, float *command)
{
    const double *end = path + 3 * (poses - 1), c = cos(robot[2]), s = sin(robot[2]);
    double dx = end[0] - robot[0], dy = end[1] - robot[1];
    float distance = hypot(dx, dy);
    see_path(m, path, poses, robot, &grid);
    roll_out(m, v, w);
    find_furthest(m);
    memset(m->cost, 0, 4 * m->batch);
    judge_speeds(m, distance);
    bool blocked = judge_costs(m, distance, robot, &grid);
    judge_goal(m, distance, c * dx + s * dy, c * dy - s * dx, end[2] - robot[2]);
    if (distance >= 0.5f)
        judge_alignment(m), judge_angle(m);
    if (distance >= 1.4f)
        judge_progress(m);
    if (blocked)
        return false;
    update(m);
    for (int k = 0; k < 2; k++) {
        memmove(m->sequence[k], m->sequence[k] + 1, 4 * (m->steps - 1));
        memmove(m->history[k], m->history[k] + 1, 4 * (HISTORY - 1));
        command[k] = m->history[k][HISTORY - 1] = m->sequence[k][0];
    }
    return true;
}

/* NavFn as published: a wave of potential over flat arrays, its cells in three priority buffers.
 *
 * The peer of `python -m bringup bench planner`, which compiles it; no part of the product.
 * Written from the algorithm's description: O. Brock and O. Khatib, High-speed navigation using the
 * global dynamic window approach, ICRA 1999; K. Konolige, A gradient method for realtime robot
 * control, IROS 2000; and the constants of nav2_navfn_planner. Costs, potentials, order of cells
 * and path are those of that planner; buffers grow to the map, so that no cell is ever dropped.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { NEUTRAL = 50, OBSTACLE = 254, INSCRIBED = 253, UNKNOWN = 255 };
static const float FAR = 1.0e10f, HALF_ROOT = 0.707106781f;
static const float STEP = 0.5f;

typedef struct {
    int *cells, count;
} Buffer;

typedef struct {
    int width, height, size;
    uint8_t *costs;
    bool *pending;
    float *potential, *grad_x, *grad_y, *path_x, *path_y;
    Buffer now, next, over;
    float threshold, increment;
} Plan;

void plan_free(Plan *p)
{
    if (!p)
        return;
    free(p->costs), free(p->pending), free(p->potential), free(p->grad_x), free(p->grad_y);
    free(p->path_x), free(p->path_y);
    free(p->now.cells), free(p->next.cells), free(p->over.cells);
    free(p);
}

/* Make the arrays for maps of a size; they are kept from plan to plan. */
Plan *plan_make(int width, int height)
{
    Plan *p = calloc(1, sizeof *p);
    if (!p)
        return NULL;
    size_t n = (size_t)width * height;
    p->width = width, p->height = height, p->size = (int)n;
    p->costs = malloc(n), p->pending = malloc(n);
    p->potential = malloc(4 * n), p->grad_x = malloc(4 * n), p->grad_y = malloc(4 * n);
    p->path_x = malloc(8 * n), p->path_y = malloc(8 * n);
    p->now.cells = malloc(4 * n), p->next.cells = malloc(4 * n), p->over.cells = malloc(4 * n);
    return p;
}

/* Take a costmap: 50 + 0.8 c where the robot's centre may be, unknown as dear as can be. */
static void set_costs(Plan *p, const uint8_t *map)
{
    for (int i = 0; i < p->size; i++) {
        int cost = map[i], own = OBSTACLE;
        if (cost < INSCRIBED) {
            own = (int)(NEUTRAL + 0.8 * cost);
            if (own >= OBSTACLE)
                own = OBSTACLE - 1;
        } else if (cost == UNKNOWN) {
            own = OBSTACLE - 1;
        }
        p->costs[i] = (uint8_t)own;
    }
    int w = p->width, last = (p->height - 1) * w;
    memset(p->costs, OBSTACLE, w), memset(p->costs + last, OBSTACLE, w);
    for (int i = 0; i < p->size; i += w)
        p->costs[i] = p->costs[i + w - 1] = OBSTACLE;
}

static void push(Plan *p, Buffer *b, int n)
{
    if (n >= 0 && n < p->size && !p->pending[n] && p->costs[n] < OBSTACLE) {
        b->cells[b->count++] = n;
        p->pending[n] = true;
    }
}

static void set_up(Plan *p, int seed)
{
    for (int i = 0; i < p->size; i++) {
        p->potential[i] = FAR;
        p->grad_x[i] = p->grad_y[i] = 0.0f;
    }
    memset(p->pending, 0, p->size);
    p->now.count = p->next.count = p->over.count = 0;
    p->threshold = OBSTACLE, p->increment = 2 * NEUTRAL;
    p->potential[seed] = 0.0f;
    push(p, &p->now, seed + 1), push(p, &p->now, seed - 1);
    push(p, &p->now, seed - p->width), push(p, &p->now, seed + p->width);
}

/* Give a cell the potential that its neighbours make, and queue those that it may lower. `left` is
 * the least that is left from it to the target, which only A* counts. */
static inline void update(Plan *p, int n, int target_x, int target_y, bool astar)
{
    const uint8_t *costs = p->costs;
    float *pot = p->potential;
    int w = p->width;
    float left = pot[n - 1], right = pot[n + 1], up = pot[n - w], down = pot[n + w];
    float across = left < right ? left : right, along = up < down ? up : down;
    if (costs[n] >= OBSTACLE)
        return;
    float cost = costs[n], gap = across - along, value;
    if (gap < 0.0f)
        gap = -gap, along = across;
    if (gap >= cost) {
        value = along + cost;
    } else {
        float d = gap / cost;
        value = along + cost * (-0.2301f * d * d + 0.5307f * d + 0.7040f);
    }
    if (value >= pot[n])
        return;
    pot[n] = value;
    if (astar) {
        int x = n % w - target_x, y = n / w - target_y;
        value += (float)(hypot(x, y) * NEUTRAL);
    }
    Buffer *b = value < p->threshold ? &p->next : &p->over;
    float own = pot[n];
    if (astar)
        own = value;  /* as nav2's: the estimate counts in what a neighbour is measured by */
    if (left > own + HALF_ROOT * costs[n - 1])
        push(p, b, n - 1);
    if (right > own + HALF_ROOT * costs[n + 1])
        push(p, b, n + 1);
    if (up > own + HALF_ROOT * costs[n - w])
        push(p, b, n - w);
    if (down > own + HALF_ROOT * costs[n + w])
        push(p, b, n + w);
}

static void swap(Buffer *a, Buffer *b)
{
    Buffer c = *a;
    *a = *b, *b = c;
}

static bool propagate(Plan *p, int seed, int target, bool astar)
{
    int x = target % p->width, y = target / p->width;
    if (astar)
        p->threshold = (float)(hypot(seed % p->width - x, seed / p->width - y) * NEUTRAL) + OBSTACLE;
    while (p->now.count || p->next.count) {
        for (int i = 0; i < p->now.count; i++)
            p->pending[p->now.cells[i]] = false;
        for (int i = 0; i < p->now.count; i++)
            update(p, p->now.cells[i], x, y, astar);
        p->now.count = 0;
        swap(&p->now, &p->next);
        if (!p->now.count) {
            p->threshold += p->increment;
            swap(&p->now, &p->over);
        }
        if (p->potential[target] < FAR)
            return true;
    }
    return p->potential[target] < FAR;
}

static void gradient(Plan *p, int n)
{
    int w = p->width;
    if (p->grad_x[n] != 0.0f || p->grad_y[n] != 0.0f || n < w || n >= p->size - w)
        return;
    float here = p->potential[n], dx = 0.0f, dy = 0.0f;
    float left = p->potential[n - 1], right = p->potential[n + 1];
    float up = p->potential[n - w], down = p->potential[n + w];
    if (here >= FAR) {
        dx = left < FAR ? -OBSTACLE : right < FAR ? OBSTACLE : 0.0f;
        dy = up < FAR ? -OBSTACLE : down < FAR ? OBSTACLE : 0.0f;
    } else {
        dx = (left < FAR ? left - here : 0.0f) + (right < FAR ? here - right : 0.0f);
        dy = (up < FAR ? up - here : 0.0f) + (down < FAR ? here - down : 0.0f);
    }
    float norm = hypotf(dx, dy);
    if (norm > 0.0f)
        p->grad_x[n] = dx / norm, p->grad_y[n] = dy / norm;
}

static float blend(const float *g, int n, int w, float a, float b)
{
    float upper = (1.0f - a) * g[n] + a * g[n + 1], lower = (1.0f - a) * g[n + w] + a * g[n + w + 1];
    return (1.0f - b) * upper + b * lower;
}

/* Follow the potential from a cell down to the seed; return the number of points, 0 for none. */
static int descend(Plan *p, int from, int seed)
{
    int w = p->width, n = from, count = 0, most = p->size * 2;
    float dx = 0.0f, dy = 0.0f;
    while (count < most) {
        int nearest = n + (int)roundf(dx) + w * (int)roundf(dy);
        if (nearest < 0 || nearest >= p->size)
            nearest = n;
        if (p->potential[nearest] < NEUTRAL || nearest == seed) {
            p->path_x[count] = (float)(seed % w), p->path_y[count] = (float)(seed / w);
            return count + 1;
        }
        if (n < w || n >= p->size - 2 * w)
            return 0;
        p->path_x[count] = n % w + dx, p->path_y[count] = n / w + dy;
        count++;
        bool circles = count > 2 && p->path_x[count - 1] == p->path_x[count - 3] &&
                       p->path_y[count - 1] == p->path_y[count - 3];
        bool edge = circles;
        for (int row = -1; row <= 1 && !edge; row++)
            for (int column = -1; column <= 1; column++)
                edge |= p->potential[n + row * w + column] >= FAR;
        if (edge) {
            int best = n;
            for (int row = -1; row <= 1; row++)
                for (int column = -1; column <= 1; column++) {
                    int other = n + row * w + column;
                    if (p->potential[other] < p->potential[best])
                        best = other;
                }
            if (best == n)
                return 0;
            n = best, dx = dy = 0.0f;
            continue;
        }
        gradient(p, n), gradient(p, n + 1), gradient(p, n + w), gradient(p, n + w + 1);
        float x = blend(p->grad_x, n, w, dx, dy), y = blend(p->grad_y, n, w, dx, dy);
        float norm = hypotf(x, y);
        if (norm == 0.0f)
            return 0;
        dx += x * STEP / norm, dy += y * STEP / norm;
        if (dx > 1.0f)
            n += 1, dx -= 1.0f;
        if (dx < -1.0f)
            n -= 1, dx += 1.0f;
        if (dy > 1.0f)
            n += w, dy -= 1.0f;
        if (dy < -1.0f)
            n -= w, dy += 1.0f;
    }
    return 0;
}

/* Plan on a map from a cell to another; return the path's number of points, 0 where none is. */
int plan_path(Plan *p, const uint8_t *map, int start, int goal, int astar)
{
    set_costs(p, map);
    p->costs[start] = NEUTRAL; /* the robot's own cell is free */
    set_up(p, start);
    if (!propagate(p, start, goal, astar))
        return 0;
    return descend(p, goal, start);
}

/* The potentials of the last plan, and its path's coordinates [cells]. */
const float *plan_potential(const Plan *p) { return p->potential; }
const float *plan_x(const Plan *p) { return p->path_x; }
const float *plan_y(const Plan *p) { return p->path_y; }

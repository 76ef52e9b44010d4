// Runs of a scene of `qc-bench through`.
#include "bench/through/measure.h"

#include "bench/through/oracle.h"
#include "common/interrupt.h"
#include "common/stopwatch.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace
{
//  Version 0.2.0, which is measured with these sources too, has no such statistics.

template <class Statistics> auto UnprovenOf(const Statistics& statistics, int) -> decltype(size_t(statistics.unproven))
{
    return size_t(statistics.unproven);
}

template <class Statistics> size_t UnprovenOf(const Statistics&, long)
{
    return 0;
}

template <class Statistics> auto LimitMsOf(const Statistics& statistics, int) -> decltype(double(statistics.limitMs))
{
    return statistics.limitMs;
}

template <class Statistics> double LimitMsOf(const Statistics&, long)
{
    return 0;
}

/// Energy and momentum of a run beside those of its start.
class Kept
{
  public:
    explicit Kept(const qcThroughWorld& world) : m_energy(world.Energy()), m_momentum(world.Momentum())
    {
    }

    void Step(const qcThroughWorld& world)
    {
        double energy = world.Energy() / m_energy;
        // Not std::max, which drops NaN.
        m_maxEnergy = energy <= m_maxEnergy ? m_maxEnergy : energy;
        m_part = double(world.Momentum().dot(m_momentum) / m_momentum.length2());
    }

    double MaxEnergy() const
    {
        return m_maxEnergy;
    }
    double Momentum() const
    {
        return m_part;
    }

  private:
    double m_energy, m_maxEnergy = 1, m_part = 1;
    btVector3 m_momentum;
};

/// Adds the library's own figures of the last step; the milliseconds are sums until the last run has ended.
bool AddStatistics(const qcThroughWorld& world, qcThroughKind kind, qcThroughRow* row)
{
    const qcMeshContactStatistics& mesh = world.MeshStatistics();
    row->unproven += UnprovenOf(mesh, 0);
    if (kind == qc_throughRigid)
    {
        row->detectMs += mesh.detectMs + mesh.aheadMs + LimitMsOf(mesh, 0);
        return mesh.status == qc_statusOk;
    }
    const qcSoftBodyStatistics& soft = world.SoftStatistics();
    row->unproven += size_t(soft.unproven);
    row->exempt += size_t(soft.exempt);
    row->planes += soft.planes;
    row->zoneNodes += soft.zoneNodes;
    row->detectMs += soft.detectMs;
    row->respondMs += soft.respondMs;
    return soft.status == qc_statusOk;
}

/// Pairs that penetrate at the end of the last step, as the library counts them.
size_t RemainingIn(const qcThroughWorld& world)
{
    return size_t(world.SoftStatistics().remaining);
}

void PrintStep(int run, int step, const qcThroughPairs& pairs, const qcThroughWorld& world)
{
    const qcSoftBodyStatistics& soft = world.SoftStatistics();
    btVector3 momentum = world.Momentum();
    std::fprintf(stderr, "run %d step %3d: ends %zu inside %zu tangled %zu uncertified %zu", run, step, pairs.ends,
                 pairs.inside, pairs.tangled, pairs.uncertified);
    const auto& pair = pairs.example;
    if (pairs.ends + pairs.inside > 0)
        std::fprintf(stderr, " (body %u triangle %u, body %u triangle %u)", pair[0], pair[1], pair[2], pair[3]);
    std::fprintf(stderr, "; remaining %d exempt %d unproven %d, of meshes %zu; rounds %d planes %d zone nodes %d",
                 soft.remaining, soft.exempt, soft.unproven, UnprovenOf(world.MeshStatistics(), 0), soft.rounds,
                 soft.planes, soft.zoneNodes);
    std::fprintf(stderr, "; energy %.6g, kinetic %.6g, momentum %.5g %.5g %.5g; detect %.1f respond %.1f ms\n",
                 world.Energy(), world.KineticEnergy(), double(momentum.x()), double(momentum.y()),
                 double(momentum.z()), soft.detectMs, soft.respondMs);
}

bool RunOnce(const qcThroughDef& def, int run, qcThroughRow* row)
{
    const qcThroughScene& scene = *def.scene;
    qcThroughWorldDef worldDef;
    worldDef.kind = def.kind;
    worldDef.gravity = scene.gravity;
    worldDef.hz = def.hz;
    worldDef.continuous = def.continuous;
    worldDef.threads = def.threads;
    qcThroughWorld world(worldDef);
    qcJitter jitter{unsigned(def.firstRun + run)};
    scene.build(&world, &jitter, scene.speed);
    qcThroughOracle oracle(world, def.brute);
    Kept kept(world);
    bool fails = false;
    int count = int(std::lround(scene.seconds * def.hz));
    for (int step = 1; step <= count && qcInterrupt_Signal() == 0; step++)
    {
        if (scene.drive != nullptr)
            scene.drive(&world, double(step) / def.hz, scene.speed);
        double start = qcStopwatch_NowMs();
        world.Step();
        row->stepMs += qcStopwatch_NowMs() - start;
        kept.Step(world);
        fails = !AddStatistics(world, def.kind, row) || fails;
        qcThroughPairs pairs;
        if (!oracle.Step(&pairs))
            return false;
        row->steps++;
        row->ends += pairs.ends;
        row->inside += pairs.inside;
        row->tangled += pairs.tangled;
        row->uncertified += pairs.uncertified;
        // The library finds what is crushed, too.
        bool isReported = scene.crushes && pairs.atEnd <= RemainingIn(world);
        fails = fails || (pairs.ends + pairs.inside > 0 && !isReported);
        if (def.prints)
            PrintStep(def.firstRun + run, step, pairs, world);
    }
    row->failingRuns += fails;
    double energy = scene.keeps == qc_keepsNothing || def.kind == qc_throughImplicit ? NAN : kept.MaxEnergy();
    row->energy = run > 0 && energy <= row->energy ? row->energy : energy;
    double momentum = scene.keeps == qc_keepsMomentum ? kept.Momentum() : NAN;
    bool isWorse = run == 0 || !(std::fabs(momentum - 1) <= std::fabs(row->momentum - 1));
    row->momentum = isWorse ? momentum : row->momentum;
    return true;
}
} // namespace

const char* qcThroughKindName(qcThroughKind kind)
{
    static const char* const names[] = {"classic", "deformable", "implicit", "rigid"};
    return names[kind];
}

bool qcMeasureThrough(const qcThroughDef& def, qcThroughRow* row)
{
    *row = qcThroughRow();
    row->scene = def.scene->name;
    row->world = qcThroughKindName(def.kind);
    row->precision = sizeof(btScalar) == sizeof(double) ? "double" : "float";
    row->hz = def.hz;
    for (; row->runs < def.runs && qcInterrupt_Signal() == 0; row->runs++)
        if (!RunOnce(def, row->runs, row))
            return false;
    double steps = double(std::max<size_t>(row->steps, 1));
    for (double* mean : {&row->planes, &row->zoneNodes, &row->detectMs, &row->respondMs, &row->stepMs})
        *mean /= steps;
    return true;
}

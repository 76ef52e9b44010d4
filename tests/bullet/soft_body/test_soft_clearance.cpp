// Bodies that their distance alone keeps apart over a step, against certificates for each pair of triangles.
#include "soft_body/response/clearance.h"

#include "bullet/random_numbers.h"

#include <array>
#include <limits>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
using Positions = std::vector<btVector3>;

/// Three consecutive nodes a triangle: none shares one.
constexpr size_t s_triangles = 5;

std::array<double, 9> CornersAt(const Positions& positions, size_t triangle)
{
    std::array<double, 9> corners;
    for (size_t i = 0; i < 9; i++)
        corners[i] = double(positions[3 * triangle + i / 3][int(i % 3)]);
    return corners;
}

struct Body
{
    Positions start, recorded, end;
    btScalar thickness;
};

/// Small triangles around a place, moved by `motion` from the start and by half of it to the end, with noise at both.
Body MakeBody(qcRandomNumbers& random, const btVector3& place, double noise, const btVector3& motion)
{
    Body body;
    body.thickness = random.Number(0.1, 0.4);
    btVector3 middle(0, 0, 0);
    for (size_t i = 0; i < 3 * s_triangles; i++)
    {
        if (i % 3 == 0)
            middle = place + random.Vector(2);
        btVector3 at = middle + random.Vector(0.3);
        body.recorded.push_back(at);
        body.start.push_back(at - motion + random.Vector(noise));
        body.end.push_back(at + motion / 2 + random.Vector(noise));
    }
    return body;
}

/// True if two triangles of different index, or of different bodies, are within the mean thickness.
bool AreNear(const Body& a, const Body& b)
{
    double margin = (double(a.thickness) + double(b.thickness)) / 2;
    for (size_t i = 0; i < s_triangles; i++)
        for (size_t k = 0; k < s_triangles; k++)
            if ((&a != &b || i != k) &&
                qcTrianglesWithin(CornersAt(a.recorded, i).data(), CornersAt(b.recorded, k).data(), margin, nullptr))
                return true;
    return false;
}

void CheckCertificates(const Body& a, const Body& b)
{
    double direction[3];
    for (size_t i = 0; i < s_triangles; i++)
        for (size_t k = 0; k < s_triangles; k++)
            if (&a != &b || i != k)
                ck_assert(qcTrianglesStayApart(CornersAt(a.start, i).data(), CornersAt(a.end, i).data(),
                                               CornersAt(b.start, k).data(), CornersAt(b.end, k).data(), direction));
}

void Record(qcSoftClearance& clearance, const Body* bodies, size_t count, const std::vector<qcContact>& contacts)
{
    clearance.Clear();
    for (size_t i = 0; i < count; i++)
        clearance.Record(uint32_t(2 * i), bodies[i].thickness, bodies[i].start, bodies[i].recorded);
    qcResult result = {};
    result.contacts = contacts.data();
    result.contactCount = contacts.size();
    clearance.RecordNear(result);
    for (size_t i = 0; i < count; i++)
        clearance.MeasureEnd(uint32_t(2 * i), bodies[i].end);
}

qcContact ContactOf(uint32_t slotA, uint32_t slotB)
{
    qcContact contact = {};
    contact.bodyA = slotA;
    contact.bodyB = slotB;
    return contact;
}
} // namespace

START_TEST(each_pair_of_bodies_that_is_kept_apart_has_certificates)
{
    qcSoftClearance clearance;
    int kept[2] = {0, 0}, left[2] = {0, 0};
    for (unsigned start = 1; start <= 4000; start++)
    {
        qcRandomNumbers random(start);
        double noise = double(random.Number(0, 0.12));
        btVector3 motion = random.Vector(3);
        Body bodies[2] = {MakeBody(random, btVector3(0, 0, 0), noise, motion),
                          MakeBody(random, random.Vector(2), noise, motion + random.Vector(noise))};
        std::vector<qcContact> contacts;
        for (uint32_t a = 0; a < 2; a++)
            for (uint32_t b = a; b < 2; b++)
                if (AreNear(bodies[a], bodies[b]))
                    contacts.push_back(ContactOf(2 * b, 2 * a));
        Record(clearance, bodies, 2, contacts);
        for (uint32_t a = 0; a < 2; a++)
            for (uint32_t b = a; b < 2; b++)
            {
                bool keeps = clearance.KeepsApart(2 * a, 2 * b);
                ck_assert(clearance.KeepsApart(2 * b, 2 * a) == keeps);
                (keeps ? kept : left)[a != b]++;
                if (keeps)
                    CheckCertificates(bodies[a], bodies[b]);
            }
    }
    for (int between = 0; between < 2; between++)
        ck_assert(kept[between] > 20 && left[between] > 500);
}
END_TEST

START_TEST(what_is_near_moved_away_or_not_recorded_is_not_kept_apart)
{
    qcRandomNumbers random(1);
    const btVector3 still(0, 0, 0);
    Body bodies[2] = {MakeBody(random, still, 0, still), MakeBody(random, btVector3(9, 0, 0), 0, still)};
    qcSoftClearance clearance;
    ck_assert(!clearance.KeepsApart(0, 2));
    Record(clearance, bodies, 2, {});
    ck_assert(clearance.KeepsApart(0, 2) && clearance.KeepsApart(2, 2));
    ck_assert(!clearance.KeepsApart(0, 1) && !clearance.KeepsApart(1, 1) && !clearance.KeepsApart(0, 7));
    Record(clearance, bodies, 2, {ContactOf(2, 0)});
    ck_assert(!clearance.KeepsApart(0, 2) && clearance.KeepsApart(0, 0));
    qcPair pair = {};
    qcResult result = {};
    result.pairs = &pair;
    result.pairCount = 1;
    clearance.RecordNear(result);
    ck_assert(!clearance.KeepsApart(0, 0) && clearance.KeepsApart(0, 2));

    // One of them flies by more than the thickness, as a whole.
    for (btVector3& position : bodies[1].end)
        position += btVector3(0, 1, 0);
    Record(clearance, bodies, 2, {});
    ck_assert(!clearance.KeepsApart(0, 2) && clearance.KeepsApart(2, 2));
    bodies[1].end[4].setX(std::numeric_limits<btScalar>::quiet_NaN());
    Record(clearance, bodies, 2, {});
    ck_assert(!clearance.KeepsApart(2, 2) && clearance.KeepsApart(0, 0));
    clearance.Clear();
    ck_assert(!clearance.KeepsApart(0, 0));
}
END_TEST

QC_RUN_TESTS("soft_clearance", each_pair_of_bodies_that_is_kept_apart_has_certificates,
             what_is_near_moved_away_or_not_recorded_is_not_kept_apart)

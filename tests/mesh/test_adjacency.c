// Triangles across edges against a search of all triangles.
#include "support/check_ok.h"
#include "mesh/adjacency.h"
#include "support/soups.h"
#include "support/suite.h"

#include <stdbool.h>

/// Whether the triangle has the edge from u to v.
static bool HasEdge(const uint32_t* corners, uint32_t u, uint32_t v)
{
    for (int k = 0; k < 3; k++)
        if (corners[k] == u && corners[(k + 1) % 3] == v)
            return true;
    return false;
}

static bool IsProper(const uint32_t* corners)
{
    return corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0];
}

/// By the definition, from all triangles.
static uint32_t SearchAll(const qcSoup* soup, uint32_t slot, uint32_t u, uint32_t v)
{
    uint32_t found = QC_NO_SLOT, count = 0;
    for (uint32_t t = 0; t < soup->triangleCount && IsProper(soup->indices + 3 * (size_t)slot); t++)
    {
        const uint32_t* corners = soup->indices + 3 * (size_t)t;
        if (t == slot || (!HasEdge(corners, u, v) && !HasEdge(corners, v, u)))
            continue;
        count++;
        found = HasEdge(corners, v, u) && IsProper(corners) ? t : QC_NO_SLOT;
    }
    return count == 1 ? found : QC_NO_SLOT;
}

START_TEST(any_number_of_threads_finds_the_triangles_across_edges)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 36, 0.02, 0.03);
    ck_assert_uint_gt(soup.triangleCount, 2 * 1024);
    qcRandom random = {5};
    // Holes, edges of three triangles, edges that run the same way, triangles without area.
    for (int i = 0; i < 200; i++)
        soup.indices[qcRandom_Below(&random, 3 * soup.triangleCount)] = qcRandom_Below(&random, soup.vertexCount);
    for (uint32_t threads = 1; threads <= 4; threads++)
    {
        qcAdjacency adjacency;
        const qcCorners* corners = (const qcCorners*)soup.indices;
        CHECK_OK(qcAdjacency_Begin(&adjacency, corners, soup.triangleCount, soup.vertexCount));
        // In two parts, neither of which is a multiple of a block.
        qcAdjacency_FindAcross(&adjacency, corners, soup.vertexCount, 0, 1500, threads);
        qcAdjacency_FindAcross(&adjacency, corners, soup.vertexCount, 1500, soup.triangleCount, threads);
        uint32_t across = 0;
        for (uint32_t i = 0; i < 3 * soup.triangleCount; i++)
        {
            uint32_t u = soup.indices[i], v = soup.indices[i - i % 3 + (i + 1) % 3];
            ck_assert_uint_eq(QC_AT(uint32_t, adjacency.across, i), SearchAll(&soup, i / 3, u, v));
            across += QC_AT(uint32_t, adjacency.across, i) != QC_NO_SLOT;
        }
        ck_assert_uint_gt(across, 2 * soup.triangleCount);
        qcAdjacency_Free(&adjacency);
    }
    qcSoup_Free(&soup);
}
END_TEST

QC_RUN_TESTS("adjacency", any_number_of_threads_finds_the_triangles_across_edges)
